"""From the likeliest cells to poses between them: a robust fit of the scan to the map, of all candidates at once."""

from dataclasses import dataclass
from math import sqrt, tau

import numpy as np

from robots.kit.rovers.gridmap.beacon import Beacon
from robots.kit.rovers.gridmap.plan import Floats
from robots.kit.rovers.gridmap.range_map import RangeMap
from robots.kit.rovers.gridmap.scan import Scan, angle, facing

SPREADS_M = (0.25, 0.15, 0.10, 0.06, 0.04)  # of the sonar's readings in the steps of the fit: coarse, then fine
SONAR_M, INFRARED_M = 0.035, 0.02  # in the last steps: noise, inexact turns, a middle that moves during the scan
OUTLIER = 0.10  # share of readings that are echoes, or of things that the map does not have
STEP = np.array([0.01, 0.01, 0.01])  # m, m, rad, of the slopes
MOST = np.array([0.25, 0.25, 0.15])  # m, m, rad, that a step of the fit changes
STEEP = 5.0  # m/m: a range that changes more has changed from one surface to another, and has no slope
FIRST, BEST = 3, 8  # steps with all candidates, and how many go on
DAMPING = 16.0  # 1/m², 1/rad²: a direction that the readings do not determine stays almost unchanged


@dataclass(frozen=True)
class Fits:
    """Of n candidates: `poses` (n, 3), `covariances` (n, 3, 3), `score` (n,), a log likelihood.

    agree (n,): the share of the sonar's readings that fit the map.
    """

    poses: Floats
    covariances: Floats
    score: Floats
    agree: Floats


class _Fit:
    """The state of a fit: the best pose so far of each candidate, with its score and its normal equations."""

    def __init__(self, ranges: RangeMap, poses: Floats, scan: Scan, beacon: Beacon | None) -> None:
        self._ranges, self._scan, self._beacon = ranges, scan, beacon
        self._read = np.stack([scan.sonar, scan.infrared])
        self._reach = np.array([ranges.sonar_sensor.far, ranges.infrared_sensor.far])[:, None]
        count = len(poses)
        self.at, self.best = poses.copy(), poses.copy()
        self.score, self.agree = np.full(count, -np.inf), np.zeros(count)
        self.information = np.zeros((count, 3, 3))

    def keep(self, most: int) -> None:
        """Go on with the best ones only."""
        order = np.argsort(self.score)[::-1][:most]
        for name in ("at", "best", "score", "agree", "information"):
            setattr(self, name, getattr(self, name)[order])

    def _look(self) -> tuple[Floats, Floats]:
        """Return what sonar and infrared would read, less what they read: (n, 2, readings), its slopes (n, 3, ...)."""
        x, y = self.at[:, :1], self.at[:, 1:2]
        heading = self.at[:, 2:] + self._scan.turned
        steps = STEP[:, None, None, None] * np.eye(3)[:, :, None, None]
        off, slopes = [], []
        for sensor, light in ((self._ranges.sonar_sensor, False), (self._ranges.infrared_sensor, True)):
            reads, number = self._ranges.plan.look(x, y, heading, sensor, light)
            moved = x + steps[:, 0], y + steps[:, 1], heading + steps[:, 2]  # (3, n, ...)
            slopes.append(self._ranges.plan.again(*moved, sensor, number, light) - reads)
            off.append(reads)
        return np.stack(off, 1) - self._read, np.stack(slopes, 2).transpose(1, 0, 2, 3) / STEP[:, None, None]

    def step(self, spread: float) -> None:
        """Score the pose of each candidate, remember it if it is its best, and move it."""
        off, slopes = self._look()
        slopes = np.where(np.abs(slopes[:, :2]).max(1, keepdims=True) < STEEP, slopes, 0.0)
        self._remember(off, slopes)
        wide = np.array([spread, max(INFRARED_M, 0.5 * spread)])[:, None]
        push, pull = self._normal(off, slopes, wide)
        step = np.linalg.solve(push + DAMPING * np.eye(3), pull[..., None])[..., 0]
        self.at = self.at - np.clip(step, -MOST, MOST)

    def _remember(self, off: Floats, slopes: Floats) -> None:
        wide = np.array([SONAR_M, INFRARED_M])[:, None]
        floor = OUTLIER * sqrt(tau) * wide / self._reach
        near = (1.0 - OUTLIER) * np.exp(-0.5 * (off / wide) ** 2)
        score = np.log(near + floor).sum((1, 2))
        if self._scan.heading is not None:
            score += np.log(facing(self.at[:, 2], self._scan, 0.0))
        if self._beacon is not None:
            score += -0.5 * (self._beacon.differences(self.at[:, 0], self.at[:, 1]) ** 2).sum(-1)
        better = score > self.score
        self.score = np.where(better, score, self.score)
        self.best = np.where(better[:, None], self.at, self.best)
        self.agree = np.where(better, (near > floor)[:, 0].mean(-1), self.agree)
        push, _ = self._normal(off, slopes, wide)
        self.information = np.where(better[:, None, None], push, self.information)

    def _normal(self, off: Floats, slopes: Floats, wide: Floats) -> tuple[Floats, Floats]:
        """Return the normal equations (n, 3, 3) and (n, 3) of weighted least squares at `at`."""
        near = (1.0 - OUTLIER) * np.exp(-0.5 * (off / wide) ** 2)
        weights = near / (near + OUTLIER * sqrt(tau) * wide / self._reach) / wide**2
        weighed = (slopes * weights[:, None]).reshape(len(off), 3, -1)
        push = weighed @ slopes.reshape(len(off), 3, -1).transpose(0, 2, 1)
        pull = np.einsum("nkr,nr->nk", weighed, off.reshape(len(off), -1))
        if self._scan.heading is not None:
            trust = 1.0 / self._scan.heading_spread**2
            push[:, 2, 2] += trust
            pull[:, 2] += trust * angle(self.at[:, 2] - self._scan.heading)
        if self._beacon is not None:
            steps = np.array([[0.0, 0.0], [STEP[0], 0.0], [0.0, STEP[1]]])
            tried = self.at[:, None, :2] + steps
            gone = self._beacon.differences(tried[..., 0], tried[..., 1])  # (n, 3, 2)
            lean = (gone[:, 1:] - gone[:, :1]) / STEP[0]
            push[:, :2, :2] += lean @ lean.transpose(0, 2, 1)
            pull[:, :2] += np.einsum("nkr,nr->nk", lean, gone[:, 0])
        return push, pull


def fits(ranges: RangeMap, poses: Floats, scan: Scan, beacon: Beacon | None = None) -> Fits:
    """Return the poses near `poses` (n, 3) from which the scan fits the map best, each near its own."""
    fit = _Fit(ranges, poses, scan, beacon)
    for number, spread in enumerate((*SPREADS_M, SONAR_M, SONAR_M)):
        if number == FIRST:
            fit.keep(BEST)
        fit.step(spread)
    fit.best[:, 2] = angle(fit.best[:, 2])
    covariances = np.asarray(np.linalg.inv(fit.information + np.eye(3)), float)
    return Fits(fit.best, covariances, fit.score, fit.agree)
