"""The right to command: one connection at a time, by a claim with an epoch that only grows."""

from robots.kit.clock import TIMER, Timer
from simulators.irat.peer import Peer

FORGOTTEN_S = 60.0  # after so long without a commander any epoch is accepted: a wrong one locks nobody out for ever
SILENT_S = 1.0  # a commander that is silent for so long may be replaced under its own epoch


class Claims:
    """The present commander and the newest epoch. Not for several threads."""

    def __init__(self, clock: Timer = TIMER) -> None:
        self._clock = clock
        self.commander: Peer | None = None
        self._newest, self._left = 0, self._clock.monotonic()

    @property
    def epoch(self) -> int:
        """Return the commander's epoch, 0 if there is none."""
        return self.commander.epoch if self.commander else 0

    def why_not(self, peer: Peer, epoch: int) -> str:
        """Return why a claim is refused, in one sentence; an empty text if it is not."""
        other = self.commander
        if other is None and self._clock.monotonic() - self._left > FORGOTTEN_S:
            self._newest = 0
        if epoch < self._newest:
            return f"epoch {epoch} is over; {self._newest} has commanded since"
        if (
            other is not None
            and other is not peer
            and epoch == other.epoch
            and self._clock.monotonic() - other.heard_at < SILENT_S
        ):
            return f"another connection commands under epoch {epoch}"
        return ""

    def grant(self, peer: Peer, epoch: int) -> Peer | None:
        """Make `peer` the commander; return the one it replaces."""
        other = self.commander if self.commander is not peer else None
        if other is not None:
            other.epoch = 0
        self.commander, peer.epoch, self._newest = peer, epoch, epoch
        return other

    def leave(self, peer: Peer) -> bool:
        """Take the command from a peer that leaves; return whether it had the command."""
        if self.commander is not peer:
            return False
        self.commander, peer.epoch, self._left = None, 0, self._clock.monotonic()
        return True

    def forget(self) -> None:
        """Forget every epoch, as at a loss of power."""
        self.commander, self._newest, self._left = None, 0, self._clock.monotonic()
