"""The straight line of the tool: joints solved every few millimetres, with one polynomial for the time."""

from dataclasses import dataclass
from math import ceil

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from robots.kit.arms.budget import LINE_POINT, Budget
from robots.kit.arms.chain import Joints, Matrix
from robots.kit.arms.inverse import Inverse, OutOfReach
from robots.kit.arms.path import SHORTEST_S, Cubic, Limits

STEP_M = 0.005  # how densely a straight line is solved
STEP_RAD = 0.02
JUMP = 3.0  # a joint that turns this many times more than the tool passes a singular pose
PEAK = 1.5  # greatest speed of the polynomial from 0 to 1 at rest, times its seconds


@dataclass(frozen=True)
class Line:
    """A straight line of the tool: joints at equal steps from 0 to 1 of its length, timed by a cubic."""

    q: Joints  # (m, n)
    slope: Joints  # (m, n), d q / d way
    along: Cubic  # of shape (4, 1)

    @property
    def seconds(self) -> float:
        """Return the motion time (s)."""
        return self.along.seconds

    def at(self, t: float) -> tuple[Joints, Joints, Joints]:
        """Return position, velocity, acceleration of the joints."""
        way, speed, hard = (float(v[0]) for v in self.along.at(t))
        steps = len(self.q) - 1
        first = min(int(way * steps), steps - 1)
        share = way * steps - first
        q = self.q[first] + share * (self.q[first + 1] - self.q[first])
        slope = self.slope[first] + share * (self.slope[first + 1] - self.slope[first])
        return q, slope * speed, slope * hard

    def sample(self, times: Joints) -> Joints:
        """Return the positions at `times`, of shape (m, n)."""
        way = self.along.sample(times)[:, 0] * (len(self.q) - 1)
        first = np.clip(way.astype(int), 0, len(self.q) - 2)
        sampled: Joints = self.q[first] + (way - first)[:, None] * (self.q[first + 1] - self.q[first])
        return sampled

    def fastest(self) -> Joints:
        """Return each joint's greatest speed (rad/s) between any two steps."""
        steep: Joints = np.abs(np.diff(self.q, axis=0)).max(axis=0) * (len(self.q) - 1)
        return steep * PEAK / self.seconds


def line_path(inverse: Inverse, start: Joints, target: Matrix, limits: Limits, scale: float, budget: Budget) -> Line:
    """Return the straight line of the tool from rest at `start` to the pose `target`.

    Raises:
        OutOfReach: part of the line cannot be reached, or it passes a singular pose.
        TooMuch: the line is too long for the budget.

    """
    try:
        inverse.nearest(target, start, budget)  # if the end is out of reach, the rest is not computed
    except OutOfReach as error:
        raise OutOfReach(f"at the end of the straight line {error}") from error
    begin = inverse.chain.forward(start)
    far = float(np.linalg.norm(target[:3, 3] - begin[:3, 3]))
    turns = Rotation.from_matrix([begin[:3, :3], target[:3, :3]])
    angle = float((turns[0].inv() * turns[1]).magnitude())
    steps = max(2, ceil(max(far / STEP_M, angle / STEP_RAD)))
    budget.spend(LINE_POINT * steps)
    shares = np.linspace(0.0, 1.0, steps + 1)
    poses = np.tile(np.eye(4), (steps + 1, 1, 1))
    poses[:, :3, :3] = Slerp([0.0, 1.0], turns)(shares).as_matrix()
    poses[:, :3, 3] = begin[:3, 3] + shares[:, None] * (target[:3, 3] - begin[:3, 3])
    solved = [np.asarray(start, dtype=float)]
    for way, pose in zip(shares[1:], poses[1:], strict=True):
        try:
            found = inverse.nearest(pose, solved[-1], budget)
        except OutOfReach as error:
            raise OutOfReach(f"at {way:.0%} of the straight line {error}") from error
        if np.abs(found - solved[-1]).max() > JUMP * max(STEP_RAD, STEP_M / 0.1):
            raise OutOfReach(f"at {way:.0%} the straight line passes a singular pose; go there by joints")
        solved.append(found)
    q = np.array(solved)
    slope = np.gradient(q, shares, axis=0)
    return Line(q, slope, _timed(slope, limits, scale))


def _timed(slope: Joints, limits: Limits, scale: float) -> Cubic:
    """Return the cubic along the line whose speed keeps the limits of every joint."""
    steep = np.maximum(np.abs(slope).max(axis=0), 1e-9)
    speed = float(np.min(limits.velocity * scale / steep))
    hard = float(np.min(limits.acceleration / steep))
    seconds = max(SHORTEST_S, PEAK / speed, float(np.sqrt(6.0 / hard)))
    return Cubic.between(np.zeros(1), np.zeros(1), np.ones(1), seconds)
