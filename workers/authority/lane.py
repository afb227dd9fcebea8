"""One lane of the owner: a thread, its gate and its current command; and how often the owner's loops look."""

import contextlib
import threading
from collections.abc import Iterator

from robots.kit.clock import Clock, Until
from robots.models import Command
from workers.authority.gate import Gate
from workers.authority.lease import OwnerLease

SILENT_S = 2.0
MOTION, CONFIG = "motion", "config"
LIVELY_S = 3.0


class Pace:
    """Lively for some seconds after each `stir`, idle afterwards; a stir ends every idle wait at once.

    Wake-ups, open grants, commands, stops and motions stir. A late stir costs part of an idle wait and breaks no
    promise: stops and keep-alives arrive over a channel of their own.
    """

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._stirred, self._stirs = threading.Condition(), 0
        self._until = clock.monotonic() + LIVELY_S

    @property
    def lively(self) -> bool:
        """Return whether the robot is in use."""
        return self._clock.monotonic() < self._until

    def stir(self) -> None:
        """Note that the robot is in use."""
        with self._stirred:
            self._until = self._clock.monotonic() + LIVELY_S
            self._stirs += 1
            self._stirred.notify_all()

    def sleep(self, lively_s: float, idle_s: float) -> float:
        """Sleep for `lively_s`; on an idle robot for `idle_s` or until a stir. Return the chosen time (s)."""
        with self._stirred:
            if not self.lively:
                stirs = self._stirs
                self._clock.wait(Until(self._stirred, lambda: self._stirs != stirs), idle_s)
                return idle_s
        self._clock.sleep(lively_s)
        return lively_s


class Lane:
    """The state of one lane, readable from every thread. Times are monotonic (s)."""

    def __init__(self, name: str, gate: Gate, clock: Clock, pace: Pace) -> None:
        self.name, self.gate, self._clock, self.pace = name, gate, clock, pace
        self.current: Command | None = None
        self.wakes = 0  # number of wake-ups so far
        self.beat = clock.monotonic()  # when the lane's loop last went round
        self._busy_until = 0.0
        self._wake = threading.Event()
        self.turn = clock.lock()  # held while a command runs; a hold of the robot never waits for it

    @property
    def lease(self) -> OwnerLease:
        """Return the lease under which the lane runs commands."""
        return self.gate.authority.lease

    def wake(self) -> None:
        """Wake the lane: command rows may wait."""
        self.wakes += 1
        self.pace.stir()
        self._wake.set()

    def sleep(self, seconds: float) -> None:
        """Wait for a wake-up, at most `seconds` (s), and note that the loop came round."""
        self._clock.wait(self._wake, seconds)
        self._wake.clear()
        self.beat = self._clock.monotonic()

    @contextlib.contextmanager
    def taking(self, seconds: float) -> Iterator[None]:
        """Announce that the loop may be busy for `seconds` (s)."""
        self._busy_until = self._clock.monotonic() + seconds
        self.pace.stir()
        try:
            yield
        finally:
            self._busy_until = 0.0

    @contextlib.contextmanager
    def paused(self, seconds: float) -> Iterator[None]:
        """Let no command of this lane start; waits at most `seconds` (s) for the one that runs."""
        taken = self.turn.acquire(timeout=seconds)
        try:
            yield
        finally:
            if taken:
                self.turn.release()

    @property
    def busy(self) -> bool:
        """Return whether the loop runs a command or has announced that it is busy."""
        return self.current is not None or self._busy_until > self._clock.monotonic()

    @property
    def sound(self) -> bool:
        """Return whether the loop goes round, or is busy for no longer than it announced."""
        now = self._clock.monotonic()
        return now - self.beat < SILENT_S or now < self._busy_until
