"""Paces pieces of sound: they follow each other as fast as they are heard, whatever the microphone sends.

After a pause on the way what was missed comes at once, and some servers begin with the last seconds: that is left out,
because whoever listens wants the present. What comes faster all the time, as a file does, is slowed down.
"""

DEPTH = 5.0  # pieces that may come at once
MOST = 100.0  # pieces left out one after another, before their source is slowed down
FORGET = 0.01  # of a piece left out, with each that was due


class Pacer:
    """Judges pieces that last `every_s` (s); `now` is monotonic (s)."""

    def __init__(self, every_s: float, now: float) -> None:
        self._every_s, self._at = every_s, now
        self._room, self._left_out = DEPTH, 0.0

    def wait_s(self, now: float) -> float | None:
        """Return how long to wait before the next piece is sent (s), usually 0; None to leave it out."""
        due, self._at = max(0.0, now - self._at) / self._every_s, now
        self._room = min(DEPTH, self._room + due)
        self._left_out = max(0.0, self._left_out - FORGET * due)
        if self._room < 1.0 and self._left_out < MOST:
            self._left_out += 1.0
            return None
        self._room -= 1.0
        return max(0.0, -self._room * self._every_s)
