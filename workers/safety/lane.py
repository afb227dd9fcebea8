"""One lane of the owner: a thread, its gate and the command that it carries out now."""

import contextlib
import threading
from collections.abc import Iterator

from robots.clock import Clock
from robots.models import Command
from workers.safety.gate import Gate
from workers.safety.pace import Pace

SILENT_S = 2.0


class Lane:
    """What one lane is doing, readable from every thread. Times are monotonic (s)."""

    def __init__(self, gate: Gate, clock: Clock) -> None:
        self.gate, self._clock = gate, clock
        self.pace = Pace(clock)
        self.current: Command | None = None
        self.rung = 0  # how often a wake-up was heard
        self.beat = clock.monotonic()  # when the lane's loop came round last
        self._busy_until = 0.0
        self._wake = threading.Event()

    def look(self) -> None:
        """Wake the lane: command rows may wait."""
        self.rung += 1
        self.pace.stir()
        self._wake.set()

    def sleep(self, seconds: float) -> None:
        """Wait for a wake-up, at most `seconds` (s), and note that the loop came round."""
        self._wake.wait(seconds)
        self._wake.clear()
        self.beat = self._clock.monotonic()

    @contextlib.contextmanager
    def taking(self, seconds: float) -> Iterator[None]:
        """Say that the loop may be away for `seconds` (s)."""
        self._busy_until = self._clock.monotonic() + seconds
        self.pace.stir()
        try:
            yield
        finally:
            self._busy_until = 0.0

    @property
    def busy(self) -> bool:
        """Tell whether the loop is at something that takes its time."""
        return self.current is not None or self._busy_until > self._clock.monotonic()

    @property
    def sound(self) -> bool:
        """Tell whether the loop comes round, or is away for no longer than it said."""
        now = self._clock.monotonic()
        return now - self.beat < SILENT_S or now < self._busy_until
