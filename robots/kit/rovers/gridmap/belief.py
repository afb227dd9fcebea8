"""The rover's belief of its place: a histogram over x, y and heading, whose sum is 1."""

from dataclasses import dataclass, replace
from math import isfinite, tau

import numpy as np

from robots.kit.rovers.gridmap.plan import Floats
from robots.kit.rovers.gridmap.range_map import LEVEL_M, RangeMap
from robots.kit.rovers.gridmap.scan import Scan, angle, facing

Pose = tuple[float, float, float]
MOST = 1e3  # m, rad, of any number of a caller
LOST = 0.01  # share of the belief that stays everywhere: somebody may have carried the rover away
OUTLIER = 0.15  # share of readings that say nothing about the map: echoes, visitors, edges elsewhere in a cell
CELL_SHARE = 0.4  # of a cell's size: how far the readings in a cell are from those of its middle
TEMPER = 0.5  # of the log likelihood: readings of neighbouring directions see the same surface


@dataclass(frozen=True)
class Belief:
    """`mass` (bins, ny, nx) over the cells of a map; every change returns a new one."""

    ranges: RangeMap
    mass: Floats

    @classmethod
    def uniform(cls, ranges: RangeMap) -> "Belief":
        """Return the belief of a rover that knows nothing."""
        return cls(ranges, np.zeros(ranges.shape))._normal(np.broadcast_to(ranges.free, ranges.shape))

    @classmethod
    def around(
        cls, ranges: RangeMap, pose: Pose, spread: float, heading_spread: float = tau, lost: float = LOST
    ) -> "Belief":
        """Return the belief of a rover that is near a pose, with standard deviations in m and rad.

        lost: the share that is anywhere. Raises ValueError for numbers that are none or out of bounds.
        """
        numbers = *pose, spread, heading_spread
        if not (all(abs(n) < MOST for n in numbers) and spread > 0 and heading_spread > 0 and 0 <= lost <= 1):
            raise ValueError("A pose and its spread are numbers within bounds, and the spread is above 0.")
        wide, turn = np.hypot(spread, 0.5 * ranges.cell), np.hypot(heading_spread, 0.5 * tau / ranges.bins)
        away = (ranges.x - pose[0])[None, :] ** 2 + (ranges.y - pose[1])[:, None] ** 2
        at = np.exp(-0.5 * away / wide**2) * ranges.free
        looks = np.exp(-0.5 * (angle(ranges.headings - pose[2]) / turn) ** 2)
        near = cls.uniform(ranges)._normal(looks[:, None, None] * at)
        return replace(near, mass=(1.0 - lost) * near.mass + lost * cls.uniform(ranges).mass)

    def after_scan(self, scan: Scan) -> "Belief":
        """Return the belief after a scan in place, as of its last reading."""
        ranges, bins = self.ranges, self.ranges.bins
        levels = np.arange(round(ranges.sonar_sensor.far / LEVEL_M) + 1) * LEVEL_M
        wide = np.hypot(ranges.sonar_sensor.noise, CELL_SHARE * ranges.cell)
        score, part = (np.zeros((bins, ranges.sonar.shape[1]), np.float32) for _ in range(2))
        for turned, read in zip(scan.turned, scan.sonar, strict=True):
            near = (1.0 - OUTLIER) * np.exp(-0.5 * ((levels - read) / wide) ** 2)
            fits = np.log(near + OUTLIER * wide / levels[-1]).astype(np.float32)
            first = round(turned / tau * bins) % bins
            np.take(fits, ranges.sonar[first : first + bins], out=part, mode="clip")
            score += part
        mass = np.zeros(ranges.shape)
        mass[:, ranges.free] = np.exp(TEMPER * (score - score.max()))
        if scan.heading is not None:
            mass *= facing(ranges.headings, scan, tau / bins)[:, None, None]
        return self._normal(self.mass * mass)

    def times(self, at: Floats) -> "Belief":
        """Return the belief times a likelihood (ny, nx) of places, or (bins, ny, nx) of poses."""
        return self._normal(self.mass * at)

    def peaks(self, most: int) -> tuple[Floats, Floats]:
        """Return up to `most` likeliest cells that have no likelier neighbour: poses (n, 3), and their mass."""
        ranges, flat = self.ranges, self.mass.ravel()
        count = min(len(flat), 40 * most)
        order = np.argpartition(flat, -count)[-count:]
        order = order[np.argsort(flat[order])[::-1]]
        order = order[flat[order] > 0.0]
        h, y, x = np.unravel_index(order, ranges.shape)
        at = np.stack([h, y, x], 1)
        taken = np.zeros(len(order), bool)
        chosen: list[int] = []
        for n in range(len(order)):
            if taken[n]:
                continue
            chosen.append(n)
            if len(chosen) == most:
                break
            apart = np.abs(at - at[n])
            apart[:, 0] = np.minimum(apart[:, 0], ranges.bins - apart[:, 0])
            taken |= (apart <= (2, 1, 1)).all(1)
        h, y, x = at[chosen].T
        return np.column_stack([ranges.place[y, x], ranges.headings[h]]), flat[order[chosen]]

    def at(self, poses: Floats) -> Floats:
        """Return the mass (n,) of the cells in which poses (n, 3) are, 0 outside the map."""
        ranges = self.ranges
        x = np.floor((poses[:, 0] - ranges.origin[0]) / ranges.cell).astype(int)
        y = np.floor((poses[:, 1] - ranges.origin[1]) / ranges.cell).astype(int)
        h = np.round(poses[:, 2] / tau * ranges.bins).astype(int) % ranges.bins
        inside = (x >= 0) & (x < ranges.shape[2]) & (y >= 0) & (y < ranges.shape[1])
        return np.where(inside, self.mass[h, np.where(inside, y, 0), np.where(inside, x, 0)], 0.0)

    def _normal(self, mass: Floats) -> "Belief":
        """Return a belief in which only free cells have a share; all of them have the same if nothing is left."""
        kept = np.where(self.ranges.free, mass, 0.0)
        total = float(kept.sum())
        if not (isfinite(total) and total > 0.0):
            kept = np.broadcast_to(self.ranges.free, self.ranges.shape).astype(float)
            total = float(kept.sum())
        return replace(self, mass=kept / total)
