"""Detects steps of the time of day, and sleep of the machine, by clocks that are never set.

The housekeeping worker reads the clocks each second. It stores the last reading in a file, so that it also detects a
step during its own restart, and time in which the machine was off.
"""

import contextlib
import json
import logging
from collections.abc import Callable
from dataclasses import asdict
from datetime import UTC, datetime, timedelta
from functools import cache
from pathlib import Path

from django.conf import settings

from robots.kit.clock import SYSTEM, Clock
from robots.kit.clock_steps import Reading, Step, step_between
from robots.kit.files import replace_text

log = logging.getLogger(__name__)
SKIPPED = timedelta(days=1)  # after a longer step forward the date may be wrong
TRUSTED_S = 86_400.0  # the machine must be awake for this time until the date after such a step is trusted
SETTLED_S = 3600.0  # the same after a smaller step; by then all files from before it have older stamps than new ones
WRITE_S = 60.0
TOLD = "the time of day was set by %+.1f s, the machine slept or was off for %.1f s: motions and queues go on"
LONGEST_S = 1e10  # the greatest uptime that is believed
FIRST = datetime(2020, 1, 1, tzinfo=UTC)  # there was no portal before: an earlier stamp comes from a wrong clock


def boot_id() -> str:
    """Return the kernel's identifier of this start of the machine; empty if there is none."""
    with contextlib.suppress(OSError):
        return Path("/proc/sys/kernel/random/boot_id").read_text().strip()
    return ""


def _doubt_s(step: Step) -> float:
    """Return how long the date is not trusted after the step (s)."""
    if max(step.shift, step.paused, step.total) > SKIPPED:
        return TRUSTED_S
    return SETTLED_S if step.shift or step.paused else 0.0


def _read(data: bytes) -> tuple[Reading, float]:
    """Return the content of the file. Raises ValueError, TypeError, KeyError, OverflowError."""
    kept = json.loads(data)
    seen, doubted_s = Reading(**kept["seen"]), kept["doubted_s"]
    datetime.fromtimestamp(seen.wall, UTC)
    if not (0 <= seen.awake < LONGEST_S and 0 <= seen.lasted < LONGEST_S and 0 <= doubted_s <= TRUSTED_S):
        raise ValueError("no time of a machine")
    return seen, doubted_s


class WallClock:
    """Compares the time of day with clocks that are never set; thread safe. `file` stores the last reading."""

    def __init__(self, file: Path, clock: Clock = SYSTEM, boot: Callable[[], str] = boot_id) -> None:
        self._file, self._clock, self._boot = file, clock, boot
        self._lock = clock.lock()
        self._seen: Reading | None = None
        self._doubted_s = TRUSTED_S  # the time awake that is left until the date is trusted
        self._written = -WRITE_S
        self._restore()

    def _restore(self) -> None:
        try:
            seen, doubted_s = _read(self._file.read_bytes())
        except (OSError, ValueError, TypeError, KeyError, OverflowError):  # no file yet, or a truncated one
            return
        self._seen, self._doubted_s = seen, doubted_s

    def follow(self, carry: Callable[[Step, datetime], None]) -> datetime:
        """Read the clocks and return the time of day. Give a step to `carry` first, again if that raised.

        The caller judges by the returned time only, because the clock may be set at any moment.
        """
        with self._lock:
            now = self._clock.now()
            seen = Reading(self._boot(), now.timestamp(), self._clock.monotonic(), self._clock.awake())
            step = step_between(self._seen, seen) if self._seen is not None else Step(timedelta(), timedelta())
            if step.shift or step.paused:
                log.warning(TOLD, step.shift.total_seconds(), step.paused.total_seconds())
                carry(step, now)
            self._seen = seen
            self._doubted_s = max(self._doubted_s - step.since_s, _doubt_s(step))
            if step.shift or step.paused or seen.awake - self._written >= WRITE_S:
                self._written = seen.awake
                self._write(seen)
            return now

    def _write(self, seen: Reading) -> None:
        try:
            self._file.parent.mkdir(parents=True, exist_ok=True)
            replace_text(self._file, json.dumps({"seen": asdict(seen), "doubted_s": self._doubted_s}))
        except OSError:  # a full disk stops no tick; without the file the next start does not repeat this step
            with contextlib.suppress(OSError):
                self._file.unlink(missing_ok=True)

    @property
    def age_now(self) -> datetime:
        """Return the time from which the age of records is counted.

        This is the time of day. While the date is not trusted, for a day after a step of more than a day and for an
        hour after any other step, it is a time at which no record is too old.
        """
        with self._lock:
            return FIRST if self._doubted_s > 0 else self._clock.now()


@cache
def wall_clock() -> WallClock:
    """Return the wall clock of this process."""
    return WallClock(Path(settings.VAR) / "run" / "wall-clock.json")
