"""The injected clock: now, sleep, waits, threads and locks together.

Watchdogs and leases use `monotonic`. Where the platform allows it, it counts the time in which the machine is
suspended, so that closing a laptop cannot extend a lease. Time that people may use, as a turn, is measured by `awake`,
which does not count it. `now` may be set at any time: it is for texts that people read, and for rows, which
`queueing/steps.py` moves when it was set.
"""

import threading
import time
from collections.abc import Callable
from datetime import UTC, datetime
from functools import partial
from typing import Any, Protocol, overload


class Waitable(Protocol):
    """An event, or anything else that can be awaited."""

    def wait(self, timeout: float, /) -> bool:
        """Wait until it has come, for at most so many seconds (0: look only); tell whether it has."""


class Until:
    """A condition with what is awaited under it, for `Timer.wait`; the caller holds the condition's lock."""

    def __init__(self, changed: threading.Condition, holds: Callable[[], object]) -> None:
        self.changed, self.holds = changed, holds

    def wait(self, timeout: float, /) -> bool:
        """Wait until it holds, for at most so many seconds; tell whether it does."""
        return bool(self.changed.wait_for(self.holds, timeout))


class Lock(Protocol):
    """A reentrant lock that may be held while its thread waits for something else."""

    def acquire(self, blocking: bool = True, timeout: float = -1) -> bool:
        """Take it, or wait for it for at most so many seconds (-1: as long as it takes); tell whether it was taken."""

    def release(self) -> None:
        """Give it back."""

    def __enter__(self) -> bool: ...

    def __exit__(self, *_: Any) -> None: ...


def unless_busy(lock: Lock, work: Callable[[], object]) -> None:
    """Do the work under the lock; leave it out while another thread does it: a periodic task comes again."""
    if not lock.acquire(blocking=False):
        return
    try:
        work()
    finally:
        lock.release()


class Timer(Protocol):
    """Time and threads, as drivers and simulators need them."""

    def monotonic(self) -> float:
        """Return seconds that never go back."""

    def sleep(self, seconds: float, /) -> None:
        """Sleep for so many seconds."""

    def wait(self, what: Waitable, seconds: float, /) -> bool:
        """Wait for something, at most so many seconds; tell whether it came."""

    def spawn(self, run: Callable[[], object], name: str, /) -> threading.Thread:
        """Start a thread of that name, which ends with its process. Raises RuntimeError where there is no room."""

    def lock(self) -> Lock:
        """Make a lock. One that is never held while its thread waits may be a plain one."""


class MachineThreads:
    """The threads of the machine."""

    def spawn(self, run: Callable[[], object], name: str) -> threading.Thread:
        """Start a thread of that name, which ends with its process. Raises RuntimeError where there is no room."""
        thread = threading.Thread(target=run, name=name, daemon=True)
        thread.start()
        return thread

    def lock(self) -> Lock:
        """Make a lock."""
        return threading.RLock()


class FasterTimer(MachineThreads):
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
        """Wait for something, at most so many of its seconds; tell whether it came."""
        return what.wait(max(0.0, seconds) / self._factor)


TIMER: Timer = FasterTimer()  # the machine's


class Limit:
    """So many seconds by a clock, from now on."""

    def __init__(self, clock: Timer, seconds: float) -> None:
        self._clock, self._until = clock, clock.monotonic() + seconds

    @property
    def remaining(self) -> float:
        """Return the seconds that are left; not above zero once they have passed."""
        return self._until - self._clock.monotonic()

    @property
    def over(self) -> bool:
        """Return whether they have passed."""
        return self.remaining < 0


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


class Clock(Timer, Protocol):
    """Time and threads as every part of Farhand sees them; `monotonic` counts suspend."""

    def awake(self) -> float:
        """Return seconds that never go back and stand still while the machine is suspended."""

    def now(self) -> datetime:
        """Return the wall-clock time, timezone aware, UTC."""


_BOOTTIME = getattr(time, "CLOCK_BOOTTIME", None)


class MachineClock(MachineThreads):
    """The clock of the machine."""

    now = partial(datetime.now, UTC)
    awake = time.monotonic
    monotonic = time.monotonic if _BOOTTIME is None else partial(time.clock_gettime, _BOOTTIME)

    def sleep(self, seconds: float) -> None:
        """Sleep for `seconds` (s)."""
        if seconds > 0:
            time.sleep(seconds)

    def wait(self, what: Waitable, seconds: float) -> bool:
        """Wait for something, at most so many seconds; tell whether it came."""
        return what.wait(max(0.0, seconds))


class ProcessClock:
    """The clock by which this process lives: the machine's, unless it was given another (`live_by`)."""

    def __init__(self) -> None:
        self._given: Clock = MachineClock()

    def live_by(self, clock: Clock) -> Clock:
        """Live by that clock from now on; return the one before."""
        before, self._given = self._given, clock
        return before

    def monotonic(self) -> float:
        """Return seconds that never go back."""
        return self._given.monotonic()

    def awake(self) -> float:
        """Return seconds that never go back and stand still while the machine is suspended."""
        return self._given.awake()

    def now(self) -> datetime:
        """Return the wall-clock time, timezone aware, UTC."""
        return self._given.now()

    def sleep(self, seconds: float) -> None:
        """Sleep for `seconds` (s)."""
        self._given.sleep(seconds)

    def wait(self, what: Waitable, seconds: float) -> bool:
        """Wait for something, at most so many seconds; tell whether it came."""
        return self._given.wait(what, seconds)

    def spawn(self, run: Callable[[], object], name: str) -> threading.Thread:
        """Start a thread of that name, which ends with its process."""
        return self._given.spawn(run, name)

    def lock(self) -> Lock:
        """Make a lock."""
        return self._given.lock()


SYSTEM = ProcessClock()
