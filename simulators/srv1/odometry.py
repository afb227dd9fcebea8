"""Dead reckoning of the rover: ways by its encoders, the heading by encoders and compass, as its firmware does it.

Four wheels slip sideways in each turn, so the heading by encoders alone is soon wrong; the compass draws it back. A
rover is switched on at `hall.home`, so its coordinates are the hall's, but for what has slipped.
"""

from math import cos, exp, pi, radians, remainder, sin, tau

from robots.description import load

COMPASS_S = 0.6  # within which the heading follows the compass
SPEEDS_S = 0.1  # over which speeds are smoothed: an encoder's step is a large part of a short time's way


class Odometry:
    """Counts of the encoders and degrees of the compass in, a place out. Not for several threads."""

    def __init__(self, counts: tuple[int, int], compass: float) -> None:
        """`counts`: of the encoders now (left, right); `compass`: degrees clockwise from the hall's y axis."""
        description = load("srv1")
        body = description["body"]
        self._way = tau * body["wheel_radius"] / body["ticks"]  # m a count
        self._track = float(body["track"])
        self.x, self.y, _ = map(float, description["hall"]["home"])
        self.heading = remainder(_heading(compass), tau)
        self._counts = counts
        self.linear = self.angular = 0.0

    def advance(self, counts: tuple[int, int], compass: float, seconds: float) -> None:
        """Take the encoders' counts and the compass' degrees after so many seconds."""
        left, right = ((new - old) * self._way for new, old in zip(counts, self._counts, strict=True))
        self._counts = counts
        way, turn = (left + right) / 2, (right - left) / self._track
        before = self.heading
        heading = before + turn
        heading += remainder(_heading(compass) - heading, tau) * (1 - exp(-seconds / COMPASS_S))
        turned = remainder(heading - before, tau)
        middle = before + turned / 2
        self.x += way * cos(middle)
        self.y += way * sin(middle)
        self.heading = remainder(heading, tau)
        share = 1 - exp(-seconds / SPEEDS_S)
        if seconds > 0:
            self.linear += share * (way / seconds - self.linear)
            self.angular += share * (turned / seconds - self.angular)


def _heading(compass: float) -> float:
    return pi / 2 - radians(compass)
