"""Ways of the tool among objects: planned with the arm's planner, and kept off everything that lies about. Pure."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from robots.kit.arms.arrangement import Arrangement
from robots.kit.arms.budget import Budget
from robots.kit.arms.chain import Joints, Matrix
from robots.kit.arms.commands import PLACE
from robots.kit.arms.described import posture
from robots.kit.arms.motions import Motion, MotionPlanner
from robots.kit.arms.path import Path
from robots.kit.arms.planner import Refused, in_words
from robots.kit.arms.pose import numbers
from robots.kit.arms.solids import Solid, overlap
from robots.kit.description import load

MARGIN_M = 0.005  # between what is carried and what lies about
SAMPLES = 32  # postures of a way at which it is checked
CHECKED, CLOSE = 60, 8  # of the budget: the check of a way; of one posture beside one object
SAME_M, SAME = 1e-6, 1e-6  # the tool is there already


@dataclass(frozen=True)
class Way:
    """A planned motion: the command with its arguments, its end (rad), how long it lasts (s), its path."""

    kind: str
    args: dict[str, Any]
    end: Joints
    seconds: float
    path: Path


@dataclass(frozen=True)
class Backwards:
    """A path that is gone back: a straight one at rest at both ends passes the same postures at the same speeds."""

    path: Path

    @property
    def seconds(self) -> float:
        """Return the motion time (s)."""
        return self.path.seconds

    def at(self, t: float) -> tuple[Joints, Joints, Joints]:
        """Return position, velocity, acceleration of the joints."""
        q, v, a = self.path.at(self.seconds - t)
        return q, -v, a

    def sample(self, times: Joints) -> Joints:
        """Return the positions at `times`, of shape (m, n)."""
        return self.path.sample(self.seconds - times)

    def fastest(self) -> Joints:
        """Return each joint's greatest speed (rad/s)."""
        return self.path.fastest()


class Ways:
    """Plans ways one after another, each from rest at the end of the one before, `q` (rad).

    `budget` is shared by all: whoever sends a task may not let it be planned for long.
    """

    def __init__(self, planner: MotionPlanner, q: Joints, budget: Budget) -> None:
        self._planner, self._budget = planner, budget
        self._straight_before: tuple[Joints, Matrix, Way] | None = None  # from where, and by what it came here
        self.q = q

    @property
    def tool(self) -> Matrix:
        """Return where the tool is (4 x 4)."""
        return self.tool_at(self.q)

    def tool_at(self, q: Joints) -> Matrix:
        """Return the tool's pose, (..., 4, 4), for joints of shape (..., n)."""
        return self._planner.planner.chain.forward(q)

    def go(self, way: Way) -> Way:
        """Go a way; the next one begins at its end."""
        self.q = way.end
        return way

    def line(self, to: Matrix, speed: float | None = None) -> Way:
        """Return the straight way to a pose (4 x 4), at a share of full speed; back by the last one is known.

        Raises Refused.
        """
        motion, before = Motion(pose=numbers(to), straight=True, scale=speed), self._straight_before
        if before is not None and before[2].end is self.q and np.abs(before[1] - to).max() < SAME:
            begun, _, way = before
            return Way("line", _arguments(motion), begun, way.seconds, Backwards(way.path))
        tool = self.tool
        way = self._plan("line", motion)
        self._straight_before = self.q, tool, way
        return way

    def joints(self, to: Matrix) -> Way:
        """Return the way to a pose (4 x 4) by joints. Raises Refused."""
        return self._plan("pose", Motion(pose=numbers(to)))

    def posture(self, name: str) -> Way:
        """Return the way to a posture of the arm's description. Raises Refused."""
        return self._plan(name, Motion(tuple(posture(load(self._planner.driver), name))))

    def is_at(self, pose: Matrix) -> bool:
        """Tell whether the tool is at a pose."""
        return bool(np.abs(self.tool - pose).max() < SAME)

    def travel(self, to: Matrix, arrangement: Arrangement) -> list[Way]:
        """Return the ways by which the tool goes to a pose without touching an object, at most three. Raises Refused.

        By joints, else straight; else up, across above everything, and down. The first refusal is told.
        """
        if self.is_at(to):
            return []
        begun, refusals = self.q, []
        for choice in (self._by_joints, self._straight, self._above):
            self.q = begun
            try:
                return [self.go(way) for way in choice(to, arrangement)]
            except Refused as error:
                if self._budget.remaining < 0:
                    raise
                refusals.append(error)
        self.q = begun
        raise refusals[0]

    def _by_joints(self, to: Matrix, arrangement: Arrangement) -> Iterator[Way]:
        yield self._free(self.joints(to), arrangement)

    def _straight(self, to: Matrix, arrangement: Arrangement) -> Iterator[Way]:
        yield self._free(self.line(to), arrangement)

    def _above(self, to: Matrix, arrangement: Arrangement) -> Iterator[Way]:
        """Yield the way up, across and down; each is gone before the next one is planned."""
        load = carried(arrangement, np.eye(4))
        below = max(-room_bottom(solid, pose) for solid in load for pose in (self.tool, to))
        tops = [solid.top for _, solid in arrangement.lying()]
        height = max([*tops, arrangement.table.height]) + below + 2 * MARGIN_M
        up, over = self.tool, to.copy()
        up[2, 3], over[2, 3] = max(up[2, 3], height), max(to[2, 3], height)
        if not self.is_at(up):
            yield self.line(up)  # away from what it stands beside
        yield self._free(self.joints(over), arrangement)
        if not self.is_at(to):
            for moving in carried(arrangement, to):
                for name, solid in arrangement.lying():
                    if overlap(moving, solid, 0.0):
                        raise Refused("box", f"there it would touch {name}")
            yield self.line(to)

    def _free(self, way: Way, arrangement: Arrangement) -> Way:
        """Return a way that is free of objects. Raises Refused."""
        with in_words():
            self._budget.spend(CHECKED)
        times = np.linspace(0.0, way.path.seconds, SAMPLES)
        with in_words():
            touched = touches(self.tool_at(way.path.sample(times)), arrangement, self._budget)
        if touched:
            raise Refused("box", f"on the way there it would touch {touched}")
        return way

    def _plan(self, kind: str, motion: Motion) -> Way:
        plan = self._planner.plan_motion(motion, self.q, np.zeros_like(self.q), self._budget)
        return Way(kind, _arguments(motion), plan.target, plan.path.seconds, plan.path)


def _arguments(motion: Motion) -> dict[str, Any]:
    found: dict[str, Any] = {} if motion.pose is None else dict(zip(PLACE, motion.pose, strict=True))
    return found | ({} if motion.scale is None else {"speed": motion.scale})


def carried(arrangement: Arrangement, tool: Matrix) -> list[Solid]:
    """Return what moves with the tool at a pose: the gripper's room, and the object that it holds."""
    load = arrangement.load()
    held = [] if load is None else [arrangement.described(load[0]).solid(tool @ load[1])]
    return [arrangement.table.fingers_at(tool), *held]


def room_bottom(solid: Solid, tool: Matrix) -> float:
    """Return how high (m) the lowest point of a solid in the tool's frame is over the tool that stands so."""
    return float((solid.corners @ tool[:3, :3].T)[:, 2].min())


def touches(tools: Matrix, arrangement: Arrangement, budget: Budget) -> str:
    """Return an object that the moving tool would touch in one of its poses (m, 4, 4), empty if none.

    Cylinders around what moves and what lies are compared in all poses at once; where two meet, the boxes themselves.
    Raises TooMuch.
    """
    lying = list(arrangement.lying())
    if not lying:
        return ""
    tops, bottoms, radii = np.array([(solid.top, solid.bottom, solid.radius) for _, solid in lying]).T
    at = np.array([solid.pose[:2, 3] for _, solid in lying])
    for moving in carried(arrangement, np.eye(4)):
        corners = moving.corners @ np.swapaxes(tools[:, :3, :3], 1, 2) + tools[:, None, :3, 3]  # (m, 8, 3)
        middles = corners.mean(axis=1)[:, :2]
        radius = np.linalg.norm(corners[:, :, :2] - middles[:, None], axis=2).max(axis=1)
        low, high = corners[:, :, 2].min(axis=1), corners[:, :, 2].max(axis=1)
        near = np.linalg.norm(middles[:, None] - at, axis=2) < radius[:, None] + radii + MARGIN_M
        level = (low[:, None] < tops + MARGIN_M) & (high[:, None] > bottoms - MARGIN_M)
        for pose, which in zip(*np.nonzero(near & level), strict=True):
            budget.spend(CLOSE)
            if overlap(replace(moving, pose=tools[pose] @ moving.pose), lying[which][1], -MARGIN_M):
                return str(lying[which][0])
    return ""
