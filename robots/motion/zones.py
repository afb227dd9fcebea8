"""Forbidden boxes: where elbow, wrist and hand must not go, checked along the whole way.

After Dziemian et al. 2004 (section "Path planning"): boxes cover the base, the table and the
cables; a motion stops before one and may only lead away from it. The paper checks the points
of elbow, wrist and end effector at each step. Here each limb is a capsule (a segment with a
radius), so that nothing between the points can enter, and a path is swept before it begins.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from robots.motion.chain import Chain, Joints, Matrix
from robots.motion.path import Path

SLACK_M = 1e-7
FINEST_S = 0.002  # a sweep never looks closer together than one step of a controller


@dataclass(frozen=True)
class Box:
    """An axis-aligned box in the frame of the base (m); a half-space is a very large one."""

    name: str
    low: tuple[float, float, float]
    high: tuple[float, float, float]


@dataclass(frozen=True)
class Limb:
    """A capsule: from `begin` to `end` (m) in the frame that moves with joint number `joint`."""

    name: str
    joint: int
    begin: tuple[float, float, float]
    end: tuple[float, float, float]
    radius: float
    spared: tuple[str, ...] = ()  # boxes it is bolted to


@dataclass(frozen=True)
class Touch:
    """A limb and the box it is in, or nearest to."""

    limb: str
    box: str
    distance: float  # m between the surfaces; negative inside

    def __str__(self) -> str:
        return f"the {self.limb} would enter {self.box}"


class Zones:
    """The boxes around one arm."""

    def __init__(self, chain: Chain, limbs: Sequence[Limb], boxes: Iterable[Box]) -> None:
        self._chain = chain
        self._limbs = tuple(limbs)
        self.boxes = tuple(boxes)
        self._pairs = [
            (i, k)
            for i, limb in enumerate(self._limbs)
            for k, box in enumerate(self.boxes)
            if box.name not in limb.spared
        ]
        self._ends = np.array([[(*limb.begin, 1.0), (*limb.end, 1.0)] for limb in self._limbs]).reshape(-1, 2, 4)
        self._joints = [limb.joint for limb in self._limbs]
        limb_of, box_of = ([pair[n] for pair in self._pairs] for n in (0, 1))
        self._limb_of = np.array(limb_of, dtype=int)
        self._radius = np.array([self._limbs[i].radius for i in limb_of])
        self._low = np.array([self.boxes[k].low for k in box_of]).reshape(-1, 3)
        self._high = np.array([self.boxes[k].high for k in box_of]).reshape(-1, 3)

    def widened(self, clearance: float) -> "Zones":
        """Return the same boxes around limbs that are thicker by `clearance` (m)."""
        limbs = [replace(limb, radius=limb.radius + clearance) for limb in self._limbs]
        return Zones(self._chain, limbs, self.boxes)

    def distances(self, q: Joints) -> Matrix:
        """Return the distance (m) of each pair of limb and box, in the order of `pair`."""
        if not self._pairs:
            return np.empty(0)
        frames = self._chain.frames(q)[self._joints]
        ends = np.einsum("lij,lej->lei", frames, self._ends)[..., :3][self._limb_of]
        between = _segments_to_boxes(ends[:, 0], ends[:, 1], self._low, self._high)
        found: Matrix = between - self._radius
        return found

    def nearest(self, q: Joints) -> Touch | None:
        """Return the pair that is nearest to touching, None where there is no box."""
        distances = self.distances(q)
        if not len(distances):
            return None
        return self._touch(int(np.argmin(distances)), distances)

    def _touch(self, which: int, distances: Matrix) -> Touch:
        i, k = self._pairs[which]
        return Touch(self._limbs[i].name, self.boxes[k].name, float(distances[which]))

    def entered(self, distances: Matrix, floor: Matrix) -> Touch | None:
        """Return a pair that is inside by more than it may be; `floor` comes from `floor` or `raised`."""
        inside = distances < floor - SLACK_M
        if not np.any(inside):
            return None
        return self._touch(int(np.argmin(np.where(inside, distances, np.inf))), distances)

    @staticmethod
    def floor(distances: Matrix) -> Matrix:
        """Return how far inside each pair may be for now: as far as it is. It may only move away."""
        return np.minimum(distances, 0.0)

    @staticmethod
    def raised(floor: Matrix, distances: Matrix) -> Matrix:
        """Return the floor after a step: who has moved away may not come back."""
        return np.maximum(floor, np.minimum(distances, 0.0))

    def swept(self, path: Path) -> tuple[float, Touch] | None:
        """Return the time (s) and pair of the first touch on the path, None where it is free.

        Advances by as much as the nearest limb has room for at the arm's greatest speed
        (conservative advancement), so that nothing thin is jumped over.
        """
        t, speed = 0.0, self._speed_bound(path)
        floor = self.floor(self.distances(path.at(0.0)[0]))
        while True:
            distances = self.distances(path.at(t)[0])
            touch = self.entered(distances, floor)
            if touch is not None:
                return t, touch
            if t >= path.seconds:
                return None
            floor = self.raised(floor, distances)
            room = float(np.min(distances - floor, initial=np.inf))
            t = min(path.seconds, t + max(FINEST_S, room / speed))

    def _speed_bound(self, path: Path) -> float:
        """Return a speed (m/s) that no point of the arm exceeds on the path."""
        fastest = getattr(path, "fastest", None)
        velocities = fastest() if fastest is not None else self._chain.velocity
        return max(1e-6, float(velocities @ self._arms))

    @property
    def _arms(self) -> Joints:
        """Return for each joint how far (m) any limb can be from its axis, at most."""
        lengths = [float(np.linalg.norm(j.origin[:3, 3])) for j in self._chain.joints]
        reach = float(np.linalg.norm(self._chain.tool[:3, 3]))
        beyond = [reach + sum(lengths[i + 1 :]) for i in range(len(lengths))]
        return np.array(beyond) + max((limb.radius for limb in self._limbs), default=0.0)


def _segments_to_boxes(begin: Matrix, end: Matrix, low: Matrix, high: Matrix) -> Matrix:
    """Return the distances (m) of n segments to n boxes, all of shape (n, 3).

    The squared distance to a convex box is convex along a segment and quadratic between the
    places where the segment crosses a plane of a face, so its least value is at one of those
    or at the minimum of one of the (at most seven) quadratics between them.
    """
    way = end - begin
    with np.errstate(divide="ignore", invalid="ignore"):
        cuts = np.concatenate([(low - begin) / way, (high - begin) / way], axis=1)
    cuts = np.clip(np.nan_to_num(cuts, nan=0.0, posinf=1.0, neginf=0.0), 0.0, 1.0)
    ends = np.sort(np.concatenate([cuts, np.zeros((len(cuts), 1)), np.ones((len(cuts), 1))], axis=1), axis=1)
    middle = (ends[:, :-1] + ends[:, 1:]) / 2
    at = begin[:, None, :] + middle[..., None] * way[:, None, :]
    below, above = at < low[:, None, :], at > high[:, None, :]
    off = np.where(below, begin[:, None, :] - low[:, None, :], np.where(above, begin[:, None, :] - high[:, None, :], 0))
    slope = np.where(below | above, way[:, None, :], 0.0)
    square = np.sum(slope * slope, axis=2)
    best = np.where(square > 0, -np.sum(slope * off, axis=2) / np.where(square > 0, square, 1.0), ends[:, :-1])
    t = np.concatenate([np.clip(best, ends[:, :-1], ends[:, 1:]), ends], axis=1)
    points = begin[:, None, :] + t[..., None] * way[:, None, :]
    gaps = np.maximum(0.0, np.maximum(low[:, None, :] - points, points - high[:, None, :]))
    distances: Matrix = np.sqrt(np.min(np.sum(gaps * gaps, axis=2), axis=1))
    return distances
