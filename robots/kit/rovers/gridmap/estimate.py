"""The rover's place and how sure it is: by the fits of a scan, or by the tower alone."""

from dataclasses import dataclass
from math import inf, isfinite, pi, remainder, tau

import numpy as np

from robots.kit.rovers.gridmap.beacon import Beacon
from robots.kit.rovers.gridmap.belief import TEMPER, Belief, Pose
from robots.kit.rovers.gridmap.plan import Floats
from robots.kit.rovers.gridmap.refine import Fits
from robots.kit.rovers.gridmap.scan import angle

SHARE = 0.95  # of the belief: within the spread, and near a pose that is known
SPREAD_M = 0.30  # a pose is known if it is within this
AGREE = 0.6  # of the sonar's readings fit the map where a pose is known
SAME_M, SAME_RAD = 0.30, 0.35  # within these two poses are one
SCALE = 1.3  # of the fit's spreads: readings share errors, which it takes for independent
PLACE_M, TURN_RAD = 0.010, 0.027  # errors outside the fit: the middle moves during the scan, and the last turn
NORMAL = 1.96  # standard deviations to each side that hold 95 %
DRAWS = np.random.default_rng(7).standard_normal((256, 2))  # always the same: an estimate is repeatable


@dataclass(frozen=True)
class Estimate:
    """The place of the rover: `pose` (x, y in m, heading in rad), and how sure it is.

    spread: radius (m) around the pose in which it is with 95 %; heading_spread: the same as an angle (rad); share: of
    the belief that is near the pose (0 to 1); agree: share of the sonar's readings that the map explains there.
    """

    pose: Pose
    spread: float
    heading_spread: float
    share: float
    agree: float = 1.0

    @property
    def is_known(self) -> bool:
        """Return whether the rover may drive by it: one place alone, within 0.3 m, that looks like it."""
        return self.share >= SHARE and self.spread <= SPREAD_M and self.agree >= AGREE


def by_fits(fits: Fits, belief: Belief) -> Estimate:
    """Return the best of several fits, each a normal distribution with its share of the whole.

    belief: before the scan that was fitted.
    """
    with np.errstate(divide="ignore"):
        score = np.log(belief.at(fits.poses)) + 0.5 * np.log(np.linalg.det(fits.covariances)) + TEMPER * fits.score
    order = np.argsort(score)[::-1]
    kept: list[int] = []
    for n in order:
        apart = fits.poses[kept] - fits.poses[n]
        same = (np.hypot(apart[:, 0], apart[:, 1]) < 0.05) & (np.abs(angle(apart[:, 2])) < 0.1)
        if not same.any():
            kept.append(int(n))
    top = fits.poses[order[0]]
    weights = np.exp(score[kept] - score[order[0]]) if score[order[0]] > -inf else np.ones(len(kept))
    weights /= weights.sum()
    poses, covariances = fits.poses[kept], fits.covariances[kept]
    apart = poses - top
    near = (np.hypot(apart[:, 0], apart[:, 1]) <= SAME_M) & (np.abs(angle(apart[:, 2])) <= SAME_RAD)
    wide = SCALE**2 * covariances + np.diag([PLACE_M**2, PLACE_M**2, TURN_RAD**2])
    drawn = apart[:, None, :2] + DRAWS @ np.linalg.cholesky(wide[:, :2, :2]).transpose(0, 2, 1)
    away = np.hypot(drawn[..., 0], drawn[..., 1])
    turns = np.abs(angle(apart[:, 2:3] + DRAWS[:, 0] * np.sqrt(wide[:, 2, 2])[:, None]))
    shares = np.repeat(weights[:, None] / len(DRAWS), len(DRAWS), 1)
    pose = float(top[0]), float(top[1]), float(top[2])
    spread, heading_spread = (_quantile(a.ravel(), shares.ravel()) for a in (away, turns))
    return Estimate(pose, spread, heading_spread, float(weights[near].sum()), float(fits.agree[order[0]]))


def by_beacon(beacon: Beacon, heading: float, heading_spread: float) -> Estimate:
    """Return where the rover is by the tower alone, without the map of the hall.

    heading: by the compass (rad), with its standard deviation. Raises ValueError for numbers that are none.
    """
    if not (isfinite(heading) and isfinite(heading_spread) and heading_spread > 0.0):
        raise ValueError("A heading is a finite number with a spread above 0.")
    across = beacon.range * beacon.bearing_spread
    spread = _quantile(np.hypot(DRAWS[:, 0] * beacon.range_spread, DRAWS[:, 1] * across), np.ones(len(DRAWS)))
    return Estimate((*beacon.place, remainder(heading, tau)), spread, min(NORMAL * heading_spread, pi), 1.0)


def _quantile(values: Floats, mass: Floats) -> float:
    order = np.argsort(values)
    held = np.cumsum(mass[order])
    return float(values[order[min(int(np.searchsorted(held, SHARE * held[-1])), len(order) - 1)]])
