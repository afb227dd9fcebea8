"""Ways of the tool among objects: planned with the arm's planner, and kept off everything that lies about. Pure."""

from collections.abc import Iterator
from dataclasses import dataclass
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
SAMPLES = 40  # postures of a way at which it is checked
CHECKED = 100  # of the budget: the check of a way
SAME_M, SAME = 1e-6, 1e-6  # the tool is there already


@dataclass(frozen=True)
class Way:
    """A planned motion: the command with its arguments, its end (rad), how long it lasts (s), its path."""

    kind: str
    args: dict[str, Any]
    end: Joints
    seconds: float
    path: Path


class Ways:
    """Plans ways one after another, each from rest at the end of the one before, `q` (rad).

    `budget` is shared by all: whoever sends a task may not let it be planned for long.
    """

    def __init__(self, planner: MotionPlanner, q: Joints, budget: Budget) -> None:
        self._planner, self._budget = planner, budget
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
        """Return the straight way to a pose (4 x 4), at a share of full speed. Raises Refused."""
        return self._plan("line", Motion(pose=numbers(to), straight=True, scale=speed))

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
        touched = touches(self.tool_at(way.path.sample(times)), arrangement)
        if touched:
            raise Refused("box", f"on the way there it would touch {touched}")
        return way

    def _plan(self, kind: str, motion: Motion) -> Way:
        plan = self._planner.plan_motion(motion, self.q, np.zeros_like(self.q), self._budget)
        args: dict[str, Any] = {} if motion.pose is None else dict(zip(PLACE, motion.pose, strict=True))
        args |= {} if motion.scale is None else {"speed": motion.scale}
        return Way(kind, args, plan.target, plan.path.seconds, plan.path)


def carried(arrangement: Arrangement, tool: Matrix) -> list[Solid]:
    """Return what moves with the tool at a pose: the gripper's room, and the object that it holds."""
    load = arrangement.load()
    held = [] if load is None else [arrangement.described(load[0]).solid(tool @ load[1])]
    return [arrangement.table.fingers_at(tool), *held]


def room_bottom(solid: Solid, tool: Matrix) -> float:
    """Return how high (m) the lowest point of a solid in the tool's frame is over the tool that stands so."""
    return float((solid.corners @ tool[:3, :3].T)[:, 2].min())


def touches(tools: Matrix, arrangement: Arrangement) -> str:
    """Return the first object that the moving tool would touch in any of its poses (m, 4, 4), empty if none.

    What moves counts as an upright cylinder around its middle, what lies as one around its own: simple and safe.
    """
    load = carried(arrangement, np.eye(4))
    for name, solid in arrangement.lying():
        for moving in load:
            middles = (tools @ moving.pose)[:, :3, 3]
            heights = np.einsum("mij,cj->mci", tools[:, :3, :3], moving.corners)[:, :, 2] + tools[:, None, 2, 3]
            spread = np.einsum("mij,cj->mci", tools[:, :3, :3], moving.corners - moving.pose[:3, 3])[:, :, :2]
            radius = np.linalg.norm(spread, axis=2).max(axis=1)
            far = np.linalg.norm(middles[:, :2] - solid.pose[:2, 3], axis=1)
            near = far < radius + solid.radius
            level = (heights.min(axis=1) < solid.top + MARGIN_M) & (heights.max(axis=1) > solid.bottom - MARGIN_M)
            if np.any(near & level):
                return name
    return ""
