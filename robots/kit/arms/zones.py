"""Forbidden boxes: where elbow, wrist and tool must not go, checked along the whole path.

After Dziemian et al. 2004 (section "Path planning"): boxes cover the base, the table and the cables; a motion stops
before one and may only lead away from it. The paper checks the points of elbow, wrist and end effector at each step.
Here each limb is a capsule (a segment with a radius), so that nothing between the points can enter, and a path is
checked before it starts.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from robots.kit.arms import segments
from robots.kit.arms.budget import GLANCED_AT, LOOK, LOOKED_AT, Budget
from robots.kit.arms.chain import Chain, Joints, Matrix
from robots.kit.arms.path import Path

SLACK_M = 1e-7
FINEST_S = 0.002  # two checked postures are never closer than one step of a controller,
FINEST_M = 0.001  # nor closer than this much of the arm's motion
FIRST_M = 0.15  # of the arm's motion between two postures of the first check
FIRST, MOST = 64, 256  # postures: at most in the first check, at most at once


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
    spared: tuple[str, ...] = ()  # boxes to which it is bolted


@dataclass(frozen=True)
class Touch:
    """A limb and the box that it is in, or nearest to."""

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
        arms = np.array([_arms(chain, limb) for limb in self._limbs]).reshape(-1, len(chain.joints))
        self._arms = arms[self._limb_of]

    def widened(self, clearance: float) -> "Zones":
        """Return the same boxes around limbs that are thicker by `clearance` (m)."""
        limbs = [replace(limb, radius=limb.radius + clearance) for limb in self._limbs]
        return Zones(self._chain, limbs, self.boxes)

    def distances(self, q: Joints) -> Matrix:
        """Return the distance (m) of each of p pairs of limb and box, (..., p) for `q` of shape (..., n)."""
        begin, end = self._segments(q)
        found: Matrix = segments.exactly(begin, end, self._low, self._high) - self._radius
        return found

    def _segments(self, q: Joints) -> tuple[Matrix, Matrix]:
        """Return both ends (..., p, 3) of the limb of each pair."""
        frames = self._chain.frames(q)[..., self._joints, :, :]
        ends = np.einsum("...lij,lej->...lei", frames, self._ends)[..., self._limb_of, :, :3]
        return ends[..., 0, :], ends[..., 1, :]

    def clear(self, q: Joints) -> bool:
        """Return quickly whether nothing is touched for certain; False may mean either."""
        begin, end = self._segments(q)
        return bool(np.all(segments.at_least(begin, end, self._low, self._high) >= self._radius))

    def still_clear(self, distances: Matrix, moved: Joints) -> bool:
        """Return quickly whether nothing is touched for certain, after each joint has moved by so much (rad, >= 0).

        `distances` (p,): those before. A limb comes no nearer than each joint's share of the way moves its farthest
        point. False may mean either.
        """
        return bool((distances > self._arms @ moved).all())

    def nearest(self, q: Joints) -> Touch | None:
        """Return the pair that is nearest to touching, None if there is no box."""
        distances = self.distances(q)
        if not len(distances):
            return None
        return self._touch(int(np.argmin(distances)), distances)

    def _touch(self, which: int, distances: Matrix) -> Touch:
        i, k = self._pairs[which]
        return Touch(self._limbs[i].name, self.boxes[k].name, float(distances[which]))

    def entered(self, distances: Matrix, floor: Matrix) -> Touch | None:
        """Return a pair that is deeper inside than allowed; `floor` comes from `floor` or `raised`."""
        inside = distances < floor - SLACK_M
        if not np.any(inside):
            return None
        return self._touch(int(np.argmin(np.where(inside, distances, np.inf))), distances)

    @staticmethod
    def floor(distances: Matrix) -> Matrix:
        """Return how deep inside a box each pair may be: as deep as it is now. It may only move away."""
        return np.minimum(distances, 0.0)

    @staticmethod
    def raised(floor: Matrix, distances: Matrix) -> Matrix:
        """Return the floor after a step: a pair that has moved away may not come back."""
        return np.maximum(floor, np.minimum(distances, 0.0))

    def swept(self, path: Path, budget: Budget | None = None) -> tuple[float, Touch] | None:
        """Return the time (s) and pair of the first touch on the path, None if it is free.

        Checks postures along the whole path at once, then more between two of them where a limb at its greatest speed
        could have reached a box and returned, so that no thin box is missed.

        Raises:
            TooMuch: that needs more checks than the budget allows.
        """
        speeds = self._arms @ path.fastest()
        fastest = max(1e-6, float(np.max(speeds, initial=0.0)))
        finest = max(FINEST_S, FINEST_M / fastest)
        times = np.linspace(0.0, path.seconds, min(FIRST, 2 + int(fastest * path.seconds / FIRST_M)))
        if budget is not None:
            budget.spend(LOOK + GLANCED_AT * len(times))
        distances, exact = self._glanced(path.sample(times))
        while True:
            floors = self._floors(distances)
            inside = np.any(distances < floors - SLACK_M, axis=1)
            last = int(np.argmax(inside)) if np.any(inside) else len(times) - 1
            gaps = np.diff(times[: last + 1])
            lowest = (distances[:last] + distances[1 : last + 1] - gaps[:, None] * speeds) / 2
            unsure = np.any(lowest < self.raised(floors, distances)[:last] - SLACK_M, axis=1) & (gaps > finest)
            doubted = np.zeros(len(times), dtype=bool)
            doubted[:last], doubted[1 : last + 1] = unsure, doubted[1 : last + 1] | unsure
            doubted[last] |= inside[last]
            again = np.flatnonzero(doubted & ~exact)
            if len(again):  # only lower bounds of their distances are known
                distances[again] = self._looked(path, times[again], budget)
                exact[again] = True
                continue
            if not np.any(unsure):
                return self._first(float(times[last]), distances[last], floors[last]) if inside[last] else None
            after = np.flatnonzero(unsure)[:MOST]
            between = times[after] + gaps[after] / 2
            distances = np.insert(distances, after + 1, self._looked(path, between, budget), axis=0)
            times, exact = np.insert(times, after + 1, between), np.insert(exact, after + 1, True)

    def _first(self, t: float, distances: Matrix, floor: Matrix) -> tuple[float, Touch]:
        touch = self.entered(distances, floor)
        assert touch is not None
        return t, touch

    def _glanced(self, q: Joints) -> tuple[Matrix, NDArray[np.bool_]]:
        """Return lower bounds of the distances (m, p) for postures (m, n), and which of them are exact.

        If a limb starts inside a box all are exact, because its depth decides how deep it may stay.
        """
        begin, end = self._segments(q)
        found = segments.at_least(begin, end, self._low, self._high) - self._radius
        if np.any(found[0] < 0.0) and np.any(self.distances(q[0]) < 0.0):
            return self.distances(q), np.ones(len(q), dtype=bool)
        found[0] = np.maximum(found[0], 0.0)
        return found, np.zeros(len(q), dtype=bool)

    def _looked(self, path: Path, times: Joints, budget: Budget | None) -> Matrix:
        """Return the distances (m, p) at `times` (m,). Raises TooMuch."""
        if budget is not None:
            budget.spend(LOOK + LOOKED_AT * len(times))
        return self.distances(path.sample(times))

    @staticmethod
    def _floors(distances: Matrix) -> Matrix:
        """Return how deep inside each pair may be at each posture, after those before it: it may only move away."""
        deepest = np.maximum.accumulate(np.minimum(distances, 0.0), axis=0)
        return np.vstack([deepest[:1], deepest[:-1]])


def _arms(chain: Chain, limb: Limb) -> list[float]:
    """Return for each joint how far (m) a point of the limb can be from its axis at most; 0 if it does not move it."""
    reach = max(float(np.linalg.norm(limb.begin)), float(np.linalg.norm(limb.end)))
    lengths = [float(np.linalg.norm(j.origin[:3, 3])) for j in chain.joints]
    return [
        reach + limb.radius + sum(lengths[i + 1 : limb.joint + 1]) if i <= limb.joint else 0.0
        for i in range(len(lengths))
    ]
