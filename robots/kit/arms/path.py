"""Paths of an arm: third-order polynomials; `robots.kit.arms.straight` has the straight line of the tool.

After Dziemian et al. 2004 (section "Path planning"; Craig 1986, section 7.3): the target is given, position and
velocity are sampled at that moment, the velocity at the target is zero, and the motion time follows from a scaling
velocity. The paper leaves open whether limits are kept; here the time is also long enough for every joint's greatest
speed and acceleration.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from robots.kit.arms.chain import Chain, Joints

SHORTEST_S = 0.05
LONGEST_S = 900.0
TRIED = 32  # motion times at once


class Path(Protocol):
    """A motion in time: joints at `t` seconds after its start."""

    @property
    def seconds(self) -> float:
        """Return the motion time (s)."""

    def at(self, t: float) -> tuple[Joints, Joints, Joints]:
        """Return (position rad, velocity rad/s, acceleration rad/s2), each of shape (n,)."""

    def sample(self, times: Joints) -> Joints:
        """Return the positions (rad) at `times` (s, of shape (m,)), of shape (m, n)."""

    def fastest(self) -> Joints:
        """Return a speed (rad/s) that each joint does not exceed on the way, of shape (n,)."""


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
        """Return position, velocity, acceleration; before the start and after the end the arm rests there."""
        rest = t >= self.seconds
        t = min(max(t, 0.0), self.seconds)
        powers = [[1.0, t, t * t, t * t * t], [0.0, 1.0, 2 * t, 3 * t * t], [0.0, 0.0, 2.0, 6 * t]]
        q, v, a = powers @ self.a
        return (q, np.zeros_like(q), np.zeros_like(q)) if rest else (q, v, a)

    def sample(self, times: Joints) -> Joints:
        """Return the positions at `times`, of shape (m, n)."""
        t = np.clip(times, 0.0, self.seconds)[:, None]
        a0, a1, a2, a3 = self.a
        sampled: Joints = a0 + t * (a1 + t * (a2 + t * a3))
        return sampled

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
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):  # if the speed has no root, or one
            half = -(a2 + np.copysign(np.sqrt(a2 * a2 - 3 * a3 * a1), a2))
            turns = np.nan_to_num(np.array([half / (3 * a3), a1 / half]), nan=0.0, posinf=0.0, neginf=0.0)
        t = np.clip(np.vstack([turns, np.zeros_like(a1), np.full_like(a1, self.seconds)]), 0.0, self.seconds)
        a0 = self.a[0]
        q = a0 + t * (a1 + t * (a2 + t * a3))
        return q.min(axis=0), q.max(axis=0)


@dataclass(frozen=True)
class Limits:
    """The limits of a path: positions (rad), speeds (rad/s), accelerations (rad/s2), each (n,)."""

    low: Joints
    high: Joints
    velocity: Joints
    acceleration: Joints

    @classmethod
    def of(cls, chain: Chain, acceleration_s: float = 0.4) -> "Limits":
        """Return the chain's limits; each joint may reach its full speed within `acceleration_s` (s)."""
        return cls(chain.low, chain.high, chain.velocity, chain.velocity / acceleration_s)


class TooFast(ValueError):
    """No polynomial from this position and velocity keeps the limits; the arm must brake first."""


def joint_path(start: Joints, velocity: Joints, target: Joints, limits: Limits, scale: float) -> Cubic:
    """Return the shortest polynomial to `target` that keeps the limits, speeds scaled by `scale` (0 to 1].

    Raises:
        TooFast: the present velocity carries a joint past its limit whatever the time.

    """
    path = Cubic.between(start, velocity, target, _shortest(target - start, velocity, limits, scale))
    if not np.any(velocity):
        return path  # from rest to rest no joint leaves the range between start and target
    low, high = path.span()
    if np.any(low < np.minimum(limits.low, start) - 1e-9) or np.any(high > np.maximum(limits.high, start) + 1e-9):
        raise TooFast("the arm moves too fast towards a limit to turn round; it brakes first")
    return path


def _shortest(way: Joints, velocity: Joints, limits: Limits, scale: float) -> float:
    """Return the shortest time (s), to 0.1 %, in which a polynomial over `way` (rad) keeps the limits.

    Raises:
        TooFast: there is none.

    """
    speed, hard = np.maximum(limits.velocity * scale, np.abs(velocity)), limits.acceleration
    if not np.any(velocity):
        seconds = max(float(np.max(1.5 * np.abs(way) / speed)), float(np.sqrt(np.max(6 * np.abs(way) / hard))))
    else:
        seconds = _tried(way, velocity, speed, hard)
    if seconds > LONGEST_S:
        raise TooFast("no motion time keeps the limits")
    return max(SHORTEST_S, seconds)


def _tried(way: Joints, velocity: Joints, speed: Joints, hard: Joints) -> float:
    """Return the shortest time (s) found by trying a coarse grid, then two finer ones."""
    times = np.geomspace(SHORTEST_S, LONGEST_S, TRIED)
    for _ in range(3):
        keep = _keeps(times, way, velocity, speed, hard)
        if not np.any(keep):
            return np.inf
        first = int(np.argmax(keep))
        if first == 0:
            return float(times[0])
        times = np.linspace(times[first - 1], times[first], TRIED)
    return float(times[-1])


def _keeps(times: Joints, way: Joints, velocity: Joints, speed: Joints, hard: Joints) -> NDArray[np.bool_]:
    """Return for each motion time (m,) whether its polynomial keeps speeds and accelerations."""
    t = times[:, None]
    a2 = 3 * way / t**2 - 2 * velocity / t
    a3 = -2 * way / t**3 + velocity / t**2
    with np.errstate(divide="ignore", invalid="ignore"):
        turn = np.clip(np.nan_to_num(np.where(np.abs(a3) > 1e-12, -a2 / (3 * a3), 0.0)), 0.0, t)
    fastest = np.maximum(np.abs(velocity), np.abs(velocity + turn * (2 * a2 + 3 * a3 * turn)))
    hardest = np.maximum(np.abs(2 * a2), np.abs(2 * a2 + 6 * a3 * t))
    keep: NDArray[np.bool_] = np.all((fastest <= speed * (1 + 1e-9)) & (hardest <= hard * (1 + 1e-9)), axis=1)
    return keep


def brake_path(start: Joints, velocity: Joints, limits: Limits) -> Cubic:
    """Return the path to rest with the hardest allowed braking of the joint that needs longest."""
    seconds = max(SHORTEST_S, float(np.max(np.abs(velocity) / limits.acceleration)))
    # constant deceleration: the cubic term vanishes
    return Cubic.between(start, velocity, start + velocity * seconds / 2, seconds)
