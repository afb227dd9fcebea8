"""The grid scan (section 7.2): the rover looks around in place and finds where it is on the map of the hall."""

from collections.abc import Callable
from itertools import pairwise
from math import remainder, tau

from robots.kit.contract.errors import GaveUp
from robots.kit.contract.session import Permit
from robots.kit.drivers.srv1.answers import Status
from robots.kit.drivers.srv1.grid_map import range_map
from robots.kit.drivers.srv1.motions import Began, Motions
from robots.kit.drivers.srv1.ways import Place
from robots.kit.rovers.grid import SCANS, TURNS, Belief, Estimate, beacon_of, locate, next_step, scan_of

UNSURE_M = 0.20  # beyond this spread it looks around before it drives to a place, and after it
HEADING_RAD = 0.1  # standard deviation of the heading by the compass
SETTLE_S = 0.3  # at rest before each reading: the compass is smoothed over this
NOT_FOUND = (
    "The rover does not know where it is: it looked around {} times. Look at the picture, drive it a little by hand, "
    "and let it look around again."
)
Looked = Callable[[int, Status], None]  # called after each reading of a look around, counted from 1


def _unnoted(number: int, status: Status) -> None:
    """Note nothing: nobody records this look around."""


class Locating:
    """Finds the place of one rover. `tower`: where that with the beacon stands (m), None where there is none."""

    def __init__(self, motions: Motions, tower: Place | None = None) -> None:
        self._motions, self._wheels, self._tower = motions, motions.wheels, tower

    @property
    def is_unsure(self) -> bool:
        """Tell whether it has to look around before it drives to a place."""
        where = self._wheels.where
        return not where.is_known or where.spread > UNSURE_M

    def look(self, permit: Permit, began: Began, on_look: Looked = _unnoted) -> Estimate:
        """Look around once, in 18 turns; use the estimated place from then on if it is certain enough."""
        readings: list[Status] = []
        for number in range(1, TURNS + 1):
            self._motions.turn(tau / TURNS, permit, began)
            self._motions.wait(SETTLE_S, permit)
            readings.append(self._wheels.ask())
            on_look(number, readings[-1])
        headings = [status.heading for status in readings]
        turns = [remainder(b - a, tau) for a, b in pairwise(headings)]
        scan = scan_of(turns, headings, [s.sonar for s in readings], [s.infrared for s in readings])
        heard = [status.beacon for status in readings if status.beacon is not None]
        beacon = beacon_of(self._tower, heard) if self._tower is not None else None
        estimate = locate(self._belief(readings[-1]), scan, beacon).estimate
        if estimate.is_known:
            self._wheels.where.take_scan(estimate.pose, estimate.spread, readings[-1])
        return estimate

    def _belief(self, status: Status) -> Belief:
        where = self._wheels.where
        if not where.is_known:
            return Belief.uniform(range_map())
        return Belief.around(range_map(), where.pose(status), max(where.spread, 0.1), HEADING_RAD)

    def find(self, permit: Permit, began: Began, tell: Callable[[str], None], on_look: Looked = _unnoted) -> None:
        """Look around until the place is known. Raises GaveUp, with what people can do, after three times."""
        for number in range(1, SCANS + 1):
            tell(f"looks where it is, for the {('first', 'second', 'third')[number - 1]} time")
            found = self.look(permit, began, on_look)
            match next_step(found, number):
                case "go":
                    return
                case "ask":
                    raise GaveUp(NOT_FOUND.format(SCANS))
