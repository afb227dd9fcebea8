"""The live link: when Redis answered last."""

from robots.clock import Clock


class Link:
    """Whether somebody could stop the robot round the queue."""

    def __init__(self, clock: Clock, gone_s: float) -> None:
        self._clock, self._gone_s = clock, gone_s
        self._seen_at = 0.0

    def seen(self) -> None:
        """Note that Redis answered."""
        self._seen_at = self._clock.monotonic()

    @property
    def down(self) -> bool:
        """Tell whether Redis has been silent for too long."""
        return self._clock.monotonic() - self._seen_at > self._gone_s

    @property
    def lost_at(self) -> float | None:
        """Return since when it is lost, by the monotonic clock (s); None where it is not."""
        return self._seen_at + self._gone_s if self.down else None
