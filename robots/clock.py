"""The injected clock: now and sleep together.

Watchdogs and leases use `monotonic`. Where the platform allows it, it counts the time in which the machine is
suspended, so that closing a laptop cannot extend a lease.
"""

import time
from datetime import UTC, datetime
from functools import partial
from typing import Protocol


class Timer(Protocol):
    """What a motion needs of a clock; the module `time` is one."""

    def monotonic(self) -> float:
        """Return seconds that never go back."""

    def sleep(self, seconds: float, /) -> None:
        """Sleep for so many seconds."""


class Clock(Timer, Protocol):
    """The time as every part of Farhand sees it; `monotonic` counts suspend."""

    def now(self) -> datetime:
        """Return the wall-clock time, timezone aware, UTC."""


_BOOTTIME = getattr(time, "CLOCK_BOOTTIME", None)


class SystemClock:
    """The clock of the machine."""

    now = partial(datetime.now, UTC)
    monotonic = time.monotonic if _BOOTTIME is None else partial(time.clock_gettime, _BOOTTIME)

    def sleep(self, seconds: float) -> None:
        """Sleep for `seconds` (s)."""
        if seconds > 0:
            time.sleep(seconds)


SYSTEM: Clock = SystemClock()
