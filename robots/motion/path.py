"""Paths of an arm: third-order polynomials, and the straight line of the hand.

After Dziemian et al. 2004 (section "Path planning"; Craig 1986, section 7.3): the target is
given, position and velocity are sampled at that moment, the velocity at the target is zero,
the motion time follows from a scaling velocity. What the paper leaves open is ours: the
time is also long enough for every joint's greatest speed and acceleration.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from robots.motion.chain import Chain, Joints, Matrix
from robots.motion.inverse import Inverse, OutOfReach

SHORTEST_S = 0.05
LONGEST_S = 900.0
LINE_STEP_M = 0.005  # how densely a straight line is solved
LINE_STEP_RAD = 0.02
JUMP = 3.0  # a joint that turns so many times more than the hand is passing a singular pose


class Path(Protocol):
    """A motion in time: joints at `t` seconds after its begin."""

    @property
    def seconds(self) -> float:
        """Return the motion time (s)."""

    def at(self, t: float) -> tuple[Joints, Joints, Joints]:
        """Return (position rad, velocity rad/s, acceleration rad/s2), each of shape (n,)."""


@dataclass(frozen=True)
class Cubic:
    """q(t) = a0 + a1 t + a2 t^2 + a3 t^3 for each joint, at rest at the target after `seconds`."""

    a: Joints  # (4, n)
    seconds: float

    @classmethod
    def between(cls, start: Joints, velocity: Joints, target: Joints, seconds: float) -> "Cubic":
        """Return the polynomial from a sampled position and velocity to rest at the target (Craig 7.11)."""
        way = target - start
        a2 = 3 * way / seconds**2 - 2 * velocity / seconds
        a3 = -2 * way / seconds**3 + velocity / seconds**2
        return cls(np.array([start, velocity, a2, a3]), seconds)

    def at(self, t: float) -> tuple[Joints, Joints, Joints]:
        """Return position, velocity, acceleration; before the begin and after the end it rests there."""
        rest = t >= self.seconds
        t = min(max(t, 0.0), self.seconds)
        a0, a1, a2, a3 = self.a
        q = a0 + t * (a1 + t * (a2 + t * a3))
        if rest:
            return q, np.zeros_like(q), np.zeros_like(q)
        return q, a1 + t * (2 * a2 + 3 * a3 * t), 2 * a2 + 6 * a3 * t

    def fastest(self) -> Joints:
        """Return each joint's greatest speed (rad/s) on the way, exactly."""
        _, a1, a2, a3 = self.a
        with np.errstate(divide="ignore", invalid="ignore"):
            turn = np.where(np.abs(a3) > 1e-12, -a2 / (3 * a3), 0.0)
        turn = np.clip(np.nan_to_num(turn), 0.0, self.seconds)
        fastest: Joints = np.maximum(np.abs(a1), np.abs(a1 + turn * (2 * a2 + 3 * a3 * turn)))
        return fastest

    def hardest(self) -> Joints:
        """Return each joint's greatest acceleration (rad/s2): it is at one of the ends."""
        _, _, a2, a3 = self.a
        hardest: Joints = np.maximum(np.abs(2 * a2), np.abs(2 * a2 + 6 * a3 * self.seconds))
        return hardest

    def span(self) -> tuple[Joints, Joints]:
        """Return the least and greatest position (rad) of each joint on the way, exactly."""
        _, a1, a2, a3 = self.a
        ends = [self.at(0.0)[0], self.at(self.seconds)[0]]
        for column in range(self.a.shape[1]):
            roots = np.roots([3 * a3[column], 2 * a2[column], a1[column]])
            for root in roots[np.abs(roots.imag) < 1e-12].real:
                if 0 < root < self.seconds:
                    ends.append(self.at(float(root))[0])
        return np.min(ends, axis=0), np.max(ends, axis=0)


@dataclass(frozen=True)
class Limits:
    """What a path keeps to: positions (rad), speeds (rad/s), accelerations (rad/s2), each (n,)."""

    low: Joints
    high: Joints
    velocity: Joints
    acceleration: Joints

    @classmethod
    def of(cls, chain: Chain, acceleration_s: float = 0.4) -> "Limits":
        """Return the chain's; each joint may reach its full speed within `acceleration_s` (s)."""
        return cls(chain.low, chain.high, chain.velocity, chain.velocity / acceleration_s)


class TooFast(ValueError):
    """No polynomial from this position and velocity keeps the limits; brake first."""


def joint_path(start: Joints, velocity: Joints, target: Joints, limits: Limits, scale: float) -> Cubic:
    """Return the shortest polynomial to `target` that keeps the limits, speeds scaled by `scale` (0 to 1].

    Raises:
        TooFast: the present velocity carries a joint past its limit whatever the time.

    """
    speed = np.maximum(limits.velocity * scale, np.abs(velocity))
    hard = limits.acceleration

    def keeps(seconds: float) -> bool:
        path = Cubic.between(start, velocity, target, seconds)
        return bool(np.all(path.fastest() <= speed * (1 + 1e-9)) and np.all(path.hardest() <= hard * (1 + 1e-9)))

    seconds = _shortest(keeps)
    path = Cubic.between(start, velocity, target, seconds)
    low, high = path.span()
    if np.any(low < np.minimum(limits.low, start) - 1e-9) or np.any(high > np.maximum(limits.high, start) + 1e-9):
        raise TooFast("the arm moves too fast towards a limit to turn round; it brakes first")
    return path


def _shortest(keeps: Callable[[float], bool]) -> float:
    """Return the shortest time (s) for which `keeps` holds from there on, to 0.1 %."""
    low, high = SHORTEST_S, SHORTEST_S
    while not keeps(high):
        low, high = high, high * 1.5
        if high > LONGEST_S:
            raise TooFast("no motion time keeps the limits")
    while high - low > 0.001 * high:
        middle = (low + high) / 2
        low, high = (low, middle) if keeps(middle) else (middle, high)
    return high


def brake_path(start: Joints, velocity: Joints, limits: Limits) -> Cubic:
    """Return the way to rest with the hardest braking allowed for the joint that needs longest."""
    seconds = max(SHORTEST_S, float(np.max(np.abs(velocity) / limits.acceleration)))
    # constant deceleration: the cubic term vanishes
    return Cubic.between(start, velocity, start + velocity * seconds / 2, seconds)


@dataclass(frozen=True)
class Line:
    """A straight line of the hand: joints solved at `ways` in (0, 1], passed in the time of a cubic."""

    ways: Joints  # (m,)
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
        q = np.array([np.interp(way, self.ways, column) for column in self.q.T])
        slope = np.array([np.interp(way, self.ways, column) for column in self.slope.T])
        return q, slope * speed, slope * hard


def line_path(inverse: Inverse, start: Joints, target: Matrix, limits: Limits, scale: float) -> Line:
    """Return the straight line of the hand from rest at `start` to the pose `target`.

    Raises:
        OutOfReach: part of the line cannot be reached, or it passes a singular pose.

    """
    begin = inverse.chain.forward(start)
    far = float(np.linalg.norm(target[:3, 3] - begin[:3, 3]))
    turns = Rotation.from_matrix([begin[:3, :3], target[:3, :3]])
    angle = float((turns[0].inv() * turns[1]).magnitude())
    steps = max(2, int(np.ceil(max(far / LINE_STEP_M, angle / LINE_STEP_RAD))))
    ways = np.linspace(0.0, 1.0, steps + 1)
    between = Slerp([0.0, 1.0], turns)(ways).as_matrix()
    solved = [np.asarray(start, dtype=float)]
    for way, turned in zip(ways[1:], between[1:], strict=True):
        pose = np.eye(4)
        pose[:3, :3] = turned
        pose[:3, 3] = begin[:3, 3] + way * (target[:3, 3] - begin[:3, 3])
        try:
            found = inverse.nearest(pose, solved[-1])
        except OutOfReach as error:
            raise OutOfReach(f"at {way:.0%} of the straight line {error}") from error
        if np.max(np.abs(found - solved[-1])) > JUMP * max(LINE_STEP_RAD, LINE_STEP_M / 0.1):
            raise OutOfReach(f"at {way:.0%} the straight line passes a singular pose; go there by joints")
        solved.append(found)
    q = np.array(solved)
    slope = np.gradient(q, ways, axis=0)
    return Line(ways, q, slope, _timed(slope, limits, scale))


def _timed(slope: Joints, limits: Limits, scale: float) -> Cubic:
    """Return the cubic of the way whose speed keeps every joint's limits all along."""
    speed = float(np.min(limits.velocity * scale / np.maximum(np.abs(slope).max(axis=0), 1e-9)))
    hard = float(np.min(limits.acceleration / np.maximum(np.abs(slope).max(axis=0), 1e-9)))
    seconds = max(SHORTEST_S, 1.5 / speed, float(np.sqrt(6.0 / hard)))
    return Cubic.between(np.zeros(1), np.zeros(1), np.ones(1), seconds)
