"""The live link: when Redis last answered."""

from robots.clock import Clock


class Link:
    """Whether a stop could arrive past the queue."""

    def __init__(self, clock: Clock, gone_s: float) -> None:
        self._clock, self._gone_s = clock, gone_s
        self._seen_at = 0.0

    def seen(self) -> None:
        """Note that Redis answered."""
        self._seen_at = self._clock.monotonic()

    @property
    def down(self) -> bool:
        """Return whether Redis has not answered for too long."""
        return self._clock.monotonic() - self._seen_at > self._gone_s

    @property
    def lost_at(self) -> float | None:
        """Return since when the link is down, by the monotonic clock (s); None if it is not."""
        return self._seen_at + self._gone_s if self.down else None
