"""Previews of an arm's motions and programs: where they would lead, computed before anything moves."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from robots.kit.arms.chain import Joints
from robots.kit.arms.commands import TARGETS, motion_of
from robots.kit.arms.described import posture
from robots.kit.arms.motions import MotionPlanner, Step, StepRefused
from robots.kit.arms.path import Path
from robots.kit.contract.capabilities import Foreseen, Judgement
from robots.kit.contract.errors import BadRequest, OutOfWorkspace
from robots.kit.contract.values import number
from robots.kit.description import load

BETWEEN_S = 0.1  # two poses of a preview
FARTHEST_RAD = 7.0


def foresee(
    planner: MotionPlanner, kind: str, args: dict[str, Any], joints: tuple[float, ...],
    program: Sequence[Step] | None = None,
) -> Foreseen:  # fmt: skip
    """Return where a command, or the steps of a `program`, would lead from rest at `joints` (rad).

    A program of which a step cannot be done, or that lasts or costs too much, has a judgement that refuses it.

    Raises:
        BadRequest: the command leads to no place, or `joints` cannot be those of the arm.
        OutOfWorkspace: the motion of a command cannot be done.

    """
    here = start_of(planner.driver, joints)
    if program is not None:
        return _preview(planner, program, here, numbered=True)
    if kind not in TARGETS and f"{kind}_deg" not in load(planner.driver)["arm"]:
        raise BadRequest(f"There is no path to show for the command {kind}: it leads to no place.")
    return _preview(planner, [motion_of(planner.driver, kind, args)], here, numbered=False)


def start_of(driver: str, joints: tuple[float, ...]) -> Joints:
    """Return the joints (rad) at which a preview starts; missing ones are as at `ready`. Raises BadRequest."""
    ready = posture(load(driver), "ready")
    if not isinstance(joints, tuple | list) or len(joints) > 2 * len(ready):
        raise BadRequest("The present joints must be a list of angles.")
    told = [number({"joint": value}, "joint") for value in joints[: len(ready)]]
    if any(abs(value) > FARTHEST_RAD for value in told):
        raise BadRequest(f"Each of the present joints must lie between -{FARTHEST_RAD:g} and {FARTHEST_RAD:g} rad.")
    return np.array([*told, *ready[len(told) :]])


def _preview(planner: MotionPlanner, steps: Sequence[Step], here: Joints, numbered: bool) -> Foreseen:
    trail = Trail(here)
    judgements: tuple[Judgement, ...] = ()
    try:
        for step, lasts, path in planner.along(steps, here):
            trail.add(step, lasts, path)
    except StepRefused as error:
        if not numbered:
            raise OutOfWorkspace(f"The arm cannot go there: {error.why}.") from error
        judgements = (Judgement(error.step, error.at_s, f"Step {error.step}: {error.why}."),)
    return trail.foreseen(planner, numbered, judgements)


class Trail:
    """The joints along the steps so far, from rest at `here` (rad)."""

    def __init__(self, here: Joints) -> None:
        self._parts, self._steps, self._seconds = [here[None]], [0], 0.0

    def add(self, step: int, seconds: float, path: Path | None) -> None:
        """Add what belongs to a step, counted from 1: how long it lasts (s), and its path, if it moves."""
        self._seconds += seconds
        if path is not None:
            count = max(2, int(seconds / BETWEEN_S))
            self._parts.append(path.sample(seconds * np.arange(1, count + 1) / count))
            self._steps += [step] * count

    def foreseen(self, planner: MotionPlanner, numbered: bool, judgements: tuple[Judgement, ...]) -> Foreseen:
        """Return the preview; `numbered`: each point of its path names its step."""
        q = np.concatenate(self._parts)
        tool = planner.planner.chain.forward(q)[:, :3, 3]
        rows = tuple(tuple(row) for row in q.tolist())
        return Foreseen(
            rows[-1], rows, tuple(tuple(row) for row in tool.tolist()), self._seconds,
            tuple(self._steps) if numbered else (), judgements=judgements,
        )  # fmt: skip
