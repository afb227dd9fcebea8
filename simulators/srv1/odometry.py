"""Dead reckoning of the rover as its firmware does it: distances by encoders, the heading by encoders and compass.

Four wheels slip sideways in each turn, so the heading by encoders alone is soon wrong; the compass corrects it. A
rover is switched on at `hall.home`, so its coordinates are the hall's, apart from the errors of slip.
"""

from math import cos, exp, pi, radians, remainder, sin, tau

from robots.kit.description import load

DEAD_S, DRIVEN_M_S = 0.3, 0.02  # an encoder is dead that counts nothing for so long while its side is driven so fast
COMPASS_S = 0.3  # within which the heading follows the compass
SPEEDS_S = 0.1  # speeds are smoothed over it, because one step of an encoder is a large part of a short way


class Odometry:
    """Computes a place from the encoders' counts and the compass' degrees. Not for several threads."""

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


class EncoderWatch:
    """Detects an encoder that counts nothing while its side is driven: it is dead, or the wheels are held fast.

    `dead`: 1 the left, 2 the right, 3 both; it stays until that side counts again, or the next motion begins.
    """

    def __init__(self, counts: tuple[int, int]) -> None:
        self._counts, self._motion, self._silent = counts, 0, [0.0, 0.0]
        self.dead = 0

    def advance(self, counts: tuple[int, int], rims: tuple[float, float], motion: int, seconds: float) -> None:
        """Take counts, the rim speeds that the motors follow (m/s) and the motion's number after so many seconds."""
        if motion != self._motion:
            self._motion, self._silent, self.dead = motion, [0.0, 0.0], 0
        for side in (0, 1):
            if counts[side] != self._counts[side]:
                self._silent[side] = 0.0
                self.dead &= ~(1 << side)
            elif abs(rims[side]) >= DRIVEN_M_S:
                self._silent[side] += seconds
                self.dead |= (self._silent[side] > DEAD_S) << side
        self._counts = counts


def _heading(compass: float) -> float:
    return pi / 2 - radians(compass)
