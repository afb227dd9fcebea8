"""The paper's polar beacon: range and bearing from a central tower, for a hall in which showcases are moved."""

from dataclasses import dataclass
from math import isfinite

import numpy as np

from robots.autonomy.gridmap.belief import Belief
from robots.autonomy.gridmap.compass import angle
from robots.autonomy.gridmap.plan import Floats

OUTLIER = 0.02  # share of readings that tell nothing


@dataclass(frozen=True)
class Beacon:
    """Where the rover is from the tower at `tower` (x, y, m): range (m) and bearing (rad, from +x to the left).

    The spreads are standard deviations. It does not tell where the rover looks.
    """

    tower: tuple[float, float]
    range: float
    bearing: float
    range_spread: float = 0.05
    bearing_spread: float = 0.02

    def __post_init__(self) -> None:
        """Refuse numbers that no tower tells: ValueError."""
        numbers = *self.tower, self.range, self.bearing
        if not all(isfinite(n) and abs(n) < 1e4 for n in numbers) or self.range < 0.0:
            raise ValueError("A beacon's range and bearing are finite numbers, and the range is not negative.")
        if not (0.0 < self.range_spread < 1e3 and 0.0 < self.bearing_spread < 1e3):
            raise ValueError("A beacon's spreads are above 0.")

    def differences(self, x: Floats, y: Floats) -> Floats:
        """Return how far places are from what it tells, (..., 2), in standard deviations of range and bearing."""
        east, north = x - self.tower[0], y - self.tower[1]
        away = (np.hypot(east, north) - self.range) / self.range_spread
        return np.stack([away, angle(np.arctan2(north, east) - self.bearing) / self.bearing_spread], -1)

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
