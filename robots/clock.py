"""The injected clock: now and sleep together.

Watchdogs and leases use `monotonic`. Where the platform allows it, it counts the time in which the machine is
suspended, so that closing a laptop cannot extend a lease. What people may use, as a turn, is measured by `awake`,
which does not count it. `now` may be set at any time: it is for what people read, and for rows, which
`queueing/steps.py` moves when it was set.
"""

import threading
import time
from collections.abc import Callable
from datetime import UTC, datetime
from functools import partial
from typing import Protocol, overload


class Waitable(Protocol):
    """An event or a condition."""

    def wait(self, timeout: float, /) -> bool:
        """Wait until it is set or notified, for at most so many seconds; tell whether it was."""


class Until:
    """A condition with what is awaited under it, for `Timer.wait`; the caller holds the condition's lock."""

    def __init__(self, changed: threading.Condition, holds: Callable[[], object]) -> None:
        self._changed, self._holds = changed, holds

    def wait(self, timeout: float, /) -> bool:
        """Wait until it holds, for at most so many seconds; tell whether it does."""
        return bool(self._changed.wait_for(self._holds, timeout))


class Timer(Protocol):
    """What drivers and simulators need of a clock."""

    def monotonic(self) -> float:
        """Return seconds that never go back."""

    def sleep(self, seconds: float, /) -> None:
        """Sleep for so many seconds."""

    def wait(self, what: Waitable, seconds: float, /) -> bool:
        """Wait for an event or a condition, at most so many seconds; tell whether it came."""


class FasterTimer:
    """A timer on which time passes `factor` times faster than on the machine's; all of the same factor agree."""

    def __init__(self, factor: float = 1.0) -> None:
        self._factor = factor

    def monotonic(self) -> float:
        """Return seconds that never go back."""
        return time.monotonic() * self._factor

    def sleep(self, seconds: float, /) -> None:
        """Sleep for so many of its seconds; not at all where they are not above zero."""
        time.sleep(max(0.0, seconds) / self._factor)

    def wait(self, what: Waitable, seconds: float, /) -> bool:
        """Wait for an event or a condition, at most so many of its seconds; tell whether it came."""
        return what.wait(max(0.0, seconds) / self._factor)


TIMER: Timer = FasterTimer()  # the machine's


class Limit:
    """So many seconds by a clock, from now on."""

    def __init__(self, clock: Timer, seconds: float) -> None:
        self._clock, self._until = clock, clock.monotonic() + seconds

    @property
    def left(self) -> float:
        """The seconds that are left; not above zero once they have passed."""
        return self._until - self._clock.monotonic()

    @property
    def over(self) -> bool:
        """Whether they have passed."""
        return self.left < 0


def poll(holds: Callable[[], object], clock: Timer, limit_s: float, pause_s: float) -> bool:
    """Look each `pause_s` seconds whether it holds, for at most `limit_s`; tell whether it does."""
    limit = Limit(clock, limit_s)
    while not holds():
        if limit.over:
            return False
        clock.sleep(pause_s)
    return True


@overload
def ms_of(at: datetime) -> int: ...
@overload
def ms_of(at: None) -> None: ...
def ms_of(at: datetime | None) -> int | None:
    """Return whole milliseconds since 1970, as messages tell a time."""
    return None if at is None else int(at.timestamp() * 1000)


Wall = Callable[[], float]  # the time of day: seconds since 1970, UTC
WALL: Wall = time.time  # the machine's


class Clock(Protocol):
    """The time as every part of Farhand sees it; `monotonic` counts suspend."""

    def monotonic(self) -> float:
        """Return seconds that never go back."""

    def awake(self) -> float:
        """Return seconds that never go back and stand still while the machine is suspended."""

    def sleep(self, seconds: float, /) -> None:
        """Sleep for so many seconds."""

    def now(self) -> datetime:
        """Return the wall-clock time, timezone aware, UTC."""


_BOOTTIME = getattr(time, "CLOCK_BOOTTIME", None)


class SystemClock:
    """The clock of the machine."""

    now = partial(datetime.now, UTC)
    awake = time.monotonic
    monotonic = time.monotonic if _BOOTTIME is None else partial(time.clock_gettime, _BOOTTIME)

    def sleep(self, seconds: float) -> None:
        """Sleep for `seconds` (s)."""
        if seconds > 0:
            time.sleep(seconds)


SYSTEM: Clock = SystemClock()
