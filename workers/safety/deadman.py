"""The dead-man timer of a held motion.

A held motion goes on while keep-alives arrive from its operator's controls. It ends when the controls are
released, when no keep-alive came for `SILENT_S`, or at its longest duration. Once silence has ended it, it stays
ended: the robot is held by then, and a late keep-alive must not move it again.
"""

import threading
from dataclasses import dataclass

from robots.clock import Clock
from robots.drivers.errors import ControlsReleased
from robots.models import Command
from robots.services import START_S

SILENT_S = 0.25  # together with the braking of one short step this is half a second to rest


@dataclass
class DeadManTimer:
    """Which held motion runs, and when its last keep-alive came. Thread safe."""

    clock: Clock
    _who: tuple[int | None, int] | None = None
    _until: float = 0.0
    _heard: float = 0.0
    _released: tuple[int, int] | None = None
    _released_at: float = 0.0

    def __post_init__(self) -> None:
        """Create the lock."""
        self._lock = threading.Lock()

    def start(self, command: Command) -> None:
        """Start to wait for keep-alives of `command`."""
        now = self.clock.monotonic()
        with self._lock:
            self._who = (command.issued_by_id, command.client_seq)
            self._heard, self._until = now, now + command.limit_s
            if now - self._released_at > START_S:  # of an earlier turn, which used the same numbers
                self._released = None

    def end(self) -> None:
        """Note that no held motion runs any more."""
        with self._lock:
            self._who = None

    def hear(self, user: int, seq: int, held: bool) -> None:
        """Note a keep-alive (`held`), or that the controls were released."""
        now = self.clock.monotonic()
        with self._lock:
            if not held:
                self._released, self._released_at = (user, seq), now
            elif self._who == (user, seq) and now - self._heard <= SILENT_S:
                self._heard = now

    @property
    def ended(self) -> str:
        """Return why the held motion has to end: released, lost or long; empty while it may go on."""
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
        """Return if the held motion may go on. Raises ControlsReleased."""
        if self.ended:
            raise ControlsReleased("The controls were released.")
