"""The facts by which the gate judges, in memory: the latch of a stop, Redis's last answer, the end of each grant.

Other loops write it, so that no store can delay an answer.
"""

import math
import os
import threading
from collections.abc import Callable, Container
from datetime import datetime
from pathlib import Path

from robots.kit.clock import Clock
from robots.models import Grant


class StopLatch:
    """The latch of a stop: one byte in the file `path`, synced before the stop is confirmed. Thread safe.

    It survives a restart of everything. The database row follows the file; the robot is latched if either says so.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._lock = threading.Lock()
        self._set = path.exists()
        self.row_pending = self._set  # the row may not be written yet
        self.releases: int | None = None

    @property
    def latched(self) -> bool:
        """Return whether motion is forbidden."""
        return self._set

    def forbid(self, releases: int | None = None) -> None:
        """Forbid motion in memory, before the disk is written.

        `releases`: how many releases there had been by then; only a later release undoes this stop.
        """
        self._set = True
        self.releases = releases
        self.row_pending = True

    def keep(self) -> None:
        """Write the latch to disk before returning. With a full disk it is still latched in memory and in the row."""
        with self._lock:
            try:
                self._path.parent.mkdir(parents=True, exist_ok=True)
                descriptor = os.open(self._path, os.O_WRONLY | os.O_CREAT, 0o600)
                try:
                    os.write(descriptor, b"1")
                    os.fsync(descriptor)
                finally:
                    os.close(descriptor)
            except OSError:
                pass

    def release(self) -> None:
        """Allow motion again; starts none."""
        with self._lock:
            self._path.unlink(missing_ok=True)
            self._set = False
            self.row_pending = False


class Link:
    """The live link: whether a stop could arrive past the queue."""

    def __init__(self, clock: Clock, gone_s: float) -> None:
        self._clock, self._gone_s = clock, gone_s
        self._seen_at = 0.0

    def note_answer(self, asked_at: float | None = None) -> None:
        """Note that Redis answered what was asked at `asked_at` (monotonic, s); None: now.

        The answer says nothing of the time after the question: it may have waited for this process to run.
        """
        self._seen_at = self._clock.monotonic() if asked_at is None else asked_at

    @property
    def down(self) -> bool:
        """Return whether Redis has not answered for too long."""
        return self._clock.monotonic() - self._seen_at > self._gone_s

    @property
    def lost_at(self) -> float | None:
        """Return since when the link is down, by the monotonic clock (s); None if it is not."""
        return self._seen_at + self._gone_s if self.down else None


def stops(grant_id: int, newest: int, ended: Container[int]) -> bool:
    """Return whether a stop that was pressed under a grant counts.

    A stop of staff names no grant (0) and always counts; so does a stop under an unknown grant. A robot has one open
    grant at a time and the numbers grow, so a newer grant proves that an older one has ended.
    """
    return grant_id <= 0 or not (grant_id < newest or grant_id in ended)


class KnownGrants:
    """Shared by all lanes; written by the loops that read rows.

    The length of a grant is measured by a clock that is never set, and that stands still while the machine sleeps.
    `now` returns the time by which the rows are written, as it is at this moment.
    """

    def __init__(self, clock: Clock, now: Callable[[], datetime]) -> None:
        self._clock, self._now = clock, now
        self.newest = 0  # the newest known grant of this robot
        self.ended_ids: set[int] = set()
        self._told: dict[int, datetime] = {}  # the end that the row of a grant told last
        self._until: dict[int, float] = {}  # the same by `awake` (s)

    def know(self, grant: Grant) -> None:
        """Note until when a grant lasts.

        Only a row that tells another end than before is compared with the time of day, which may have been set since.
        It can add no more than what the end was moved by; the first one no more than how long the grant is.
        """
        self.newest = max(self.newest, grant.pk)
        told = self._told.get(grant.pk)
        if grant.until is None:
            self._told.pop(grant.pk, None)
            self._until.pop(grant.pk, None)
        elif grant.until != told:
            awake = self._clock.awake()
            length = grant.until - (told or grant.opened_at)
            most = self._until.get(grant.pk, awake) + max(0.0, length.total_seconds())
            self._until[grant.pk] = min(awake + max(0.0, (grant.until - self._now()).total_seconds()), most)
            self._told[grant.pk] = grant.until

    def know_newest(self, grant: Grant | None) -> None:
        """Note which grant was opened last, whether or not it is still open."""
        if grant is not None:
            self.newest = max(self.newest, grant.pk)
            if grant.ended_at is not None:
                self.revoke(grant.pk)

    def revoke(self, grant_id: int) -> None:
        """Let no command of that grant pass any more."""
        self.ended_ids.add(grant_id)

    def until(self, grant_id: int) -> float:
        """Return when that grant ends by the monotonic clock (s); minus infinity if it has ended, or is none (0)."""
        if grant_id in self.ended_ids or not grant_id:
            return -math.inf
        return self._clock.monotonic() + self._left(grant_id)

    def over(self, grant_id: int) -> bool:
        """Return whether that grant has ended."""
        return self._clock.monotonic() >= self.until(grant_id)

    def late(self, grant_id: int, seconds: float) -> bool:
        """Return whether the time of that grant has been up for so long (s), whether or not it was ended before."""
        return self._left(grant_id) <= -seconds

    def _left(self, grant_id: int) -> float:
        return self._until.get(grant_id, math.inf) - self._clock.awake()

    def stop_counts(self, grant_id: int) -> bool:
        """Return whether a stop that names this grant (0: none) counts: not if the grant is known to have ended."""
        return stops(grant_id, self.newest, self.ended_ids)
