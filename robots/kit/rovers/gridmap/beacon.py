"""The paper's polar beacon: range and bearing from a central tower, for a hall in which showcases are moved."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import cos, hypot, sin, sqrt

import numpy as np

from robots.kit.rovers.gridmap.belief import Belief
from robots.kit.rovers.gridmap.plan import Floats
from robots.kit.rovers.gridmap.scan import angle

OUTLIER = 0.02  # share of wrong readings
HEARD = 6  # the least readings of a scan: with fewer there is no beacon
NOISE_M, NOISE_RAD = 0.05, 0.02  # standard deviations of a reading
BIAS_M, BIAS_RAD = 0.03, 0.015  # what all readings of a place share: reflections, how the tower was set up
MEDIAN = 1.25  # the spread of a median, in spreads of a mean
MOST = 1e4  # m, rad
AGREES = 2.0  # standard deviations, within which a place is where the beacon has it


@dataclass(frozen=True)
class Beacon:
    """The rover as measured from the tower at `tower` (x, y, m): range (m) and bearing (rad, from +x to the left).

    The spreads are standard deviations. It does not tell where the rover looks.
    """

    tower: tuple[float, float]
    range: float
    bearing: float
    range_spread: float = NOISE_M
    bearing_spread: float = NOISE_RAD

    def __post_init__(self) -> None:
        """Refuse numbers that no tower tells: ValueError."""
        numbers = *self.tower, self.range, self.bearing
        if not all(abs(n) < MOST for n in numbers) or self.range < 0.0:
            raise ValueError("A beacon's range and bearing are finite numbers, and the range is not negative.")
        if not (0.0 < self.range_spread < 1e3 and 0.0 < self.bearing_spread < 1e3):
            raise ValueError("A beacon's spreads are above 0.")

    @property
    def place(self) -> tuple[float, float]:
        """Return where it has the rover (m)."""
        return self.tower[0] + self.range * cos(self.bearing), self.tower[1] + self.range * sin(self.bearing)

    def differences(self, x: Floats, y: Floats) -> Floats:
        """Return the differences of places from the beacon's range and bearing, (..., 2), in standard deviations."""
        east, north = x - self.tower[0], y - self.tower[1]
        away = (np.hypot(east, north) - self.range) / self.range_spread
        return np.stack([away, angle(np.arctan2(north, east) - self.bearing) / self.bearing_spread], -1)

    def agrees(self, x: float, y: float) -> bool:
        """Return whether a place is where the beacon has it."""
        return bool((np.abs(self.differences(np.asarray(x), np.asarray(y))) <= AGREES).all())

    def likelihood(self, belief: Belief) -> Floats:
        """Return how likely the cells (ny, nx) of a belief's map are; about 1 at the best."""
        ranges = belief.ranges
        x, y = np.meshgrid(ranges.x, ranges.y)
        # a cell is wide: near the tower it spans more bearing than the beacon's noise
        away = np.maximum(np.hypot(x - self.tower[0], y - self.tower[1]), 0.5 * ranges.cell)
        wide = np.hypot(self.range_spread, 0.4 * ranges.cell), np.hypot(self.bearing_spread, 0.4 * ranges.cell / away)
        off = self.differences(x, y)
        score = (off[..., 0] * self.range_spread / wide[0]) ** 2 + (off[..., 1] * self.bearing_spread / wide[1]) ** 2
        return np.asarray((1.0 - OUTLIER) * np.exp(-0.5 * score) + OUTLIER / 100, float)


def with_beacon(belief: Belief, beacon: Beacon) -> Belief:
    """Return the belief after a reading of the beacon."""
    return belief.times(beacon.likelihood(belief))


def beacon_of(tower: tuple[float, float], readings: Sequence[tuple[float, float]]) -> Beacon | None:
    """Return what the readings of one scan (range in m, bearing in rad) tell together: their medians.

    None where the tower was heard too seldom. Raises ValueError for numbers that no tower tells.
    """
    if len(readings) < HEARD:
        return None
    ranges, bearings = np.array(readings, float).T
    if not (np.abs([ranges, bearings]) < MOST).all():
        raise ValueError("A beacon's ranges and bearings are numbers within bounds.")
    middle = float(np.angle(np.exp(1j * bearings).mean()))
    bearing = middle + float(np.median(angle(bearings - middle)))
    share = MEDIAN / sqrt(len(readings))
    spreads = hypot(share * NOISE_M, BIAS_M), hypot(share * NOISE_RAD, BIAS_RAD)
    return Beacon(tower, float(np.median(ranges)), bearing, *spreads)
