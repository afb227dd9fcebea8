"""How far the rover has driven, and how sure it is of its place: dead reckoning loses it slowly. m, rad."""

from math import hypot, remainder, sqrt, tau

from robots.drivers.srv1.answers import Status

FRESH_M, FOUND_M = 0.03, 0.5  # where it was just started at home; where its owner has not seen how it came there
OF_WAY, OF_TURN = 0.02, 0.03  # m lost for each metre driven, and for each radian turned: four wheels slip
MOST_M = 10.0
JUMP_M = 1.0  # odometry that changes by more between two answers has begun anew


class Whereabouts:
    """Sums up the way from one status to the next. `spread` is the radius (m) in which the rover is, nine times of ten.

    What slips is random, so squares of errors are added. A new start of the rover begins at home again.
    """

    def __init__(self) -> None:
        self.driven = 0.0
        self._squared = FOUND_M**2
        self._last: Status | None = None

    @property
    def spread(self) -> float:
        """Return the radius (m)."""
        return min(sqrt(self._squared), MOST_M)

    def take(self, status: Status) -> None:
        """Take the next status."""
        last, self._last = self._last, status
        if last is None or last.boot != status.boot:
            self._squared = (FRESH_M if status.motion == 0 else FOUND_M) ** 2
            return
        way = hypot(status.x - last.x, status.y - last.y)
        if way > JUMP_M:
            self._squared = FOUND_M**2
            return
        self.driven += way
        turn = abs(remainder(status.heading - last.heading, tau))
        lost = OF_WAY * way + OF_TURN * turn
        self._squared += lost * (2 * self.spread * 0.3 + lost)  # partly the same error again, as a compass that is off
