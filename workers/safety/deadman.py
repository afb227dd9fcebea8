"""The dead-man timer of a held motion: a stream of keep-alives, and what follows when it ends.

A held motion lives while its operator's controls say so. It ends when they are released, when
nothing was heard for `SILENT_S`, or when it has lasted long enough. Once silence has ended it,
it stays ended: the robot is held by then, and a keep-alive that was late must not move it again.
"""

import threading
from dataclasses import dataclass

from robots.clock import Clock
from robots.drivers.errors import ControlsReleased
from robots.models import Command
from robots.services import START_S

SILENT_S = 0.25  # with one short step's braking after it, half a second to rest


@dataclass
class DeadManTimer:
    """Which held motion runs, and when a keep-alive for it was heard last. Thread safe."""

    clock: Clock
    _who: tuple[int | None, int] | None = None
    _until: float = 0.0
    _heard: float = 0.0
    _released: tuple[int, int] | None = None
    _released_at: float = 0.0

    def __post_init__(self) -> None:
        """Make the lock."""
        self._lock = threading.Lock()

    def start(self, command: Command) -> None:
        """Begin to wait for the keep-alives of `command`."""
        now = self.clock.monotonic()
        with self._lock:
            self._who = (command.issued_by_id, command.client_seq)
            self._heard, self._until = now, now + command.limit_s
            if now - self._released_at > START_S:  # of an earlier turn, whose numbers were the same
                self._released = None

    def end(self) -> None:
        """No held motion runs any more."""
        with self._lock:
            self._who = None

    def hear(self, user: int, seq: int, held: bool) -> None:
        """Hear a keep-alive, or that the controls were released."""
        now = self.clock.monotonic()
        with self._lock:
            if not held:
                self._released, self._released_at = (user, seq), now
            elif self._who == (user, seq) and now - self._heard <= SILENT_S:
                self._heard = now

    @property
    def ended(self) -> str:
        """Tell why the held motion has to end: released, lost, long; empty while it may go on."""
        with self._lock:
            if self._who is None:
                return ""
            now = self.clock.monotonic()
            if self._released == self._who:
                return "released"
            if now - self._heard > SILENT_S:
                return "lost"
            return "long" if now >= self._until else ""

    def check(self) -> None:
        """Return while keep-alives arrive. Raises ControlsReleased."""
        if self.ended:
            raise ControlsReleased("The controls were released.")
