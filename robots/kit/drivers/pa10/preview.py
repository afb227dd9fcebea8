"""Previews of the museum arm: where a motion or a program would lead, computed before anything moves."""

from typing import Any

import numpy as np

from robots.kit.arms.chain import Joints
from robots.kit.arms.described import posture
from robots.kit.contract.capabilities import Foreseen, Judgement
from robots.kit.contract.errors import BadRequest, OutOfWorkspace
from robots.kit.contract.values import number
from robots.kit.description import load
from robots.kit.drivers.pa10.checks import PLACES, bounded, courses, request_of, steps_of
from robots.kit.drivers.pa10.courses import Courses, StepRefused
from robots.kit.drivers.pa10.protocol import Request

BETWEEN_S = 0.1  # two poses of a preview
FARTHEST_RAD = 7.0


def foresee(kind: str, args: dict[str, Any], joints: tuple[float, ...], settings: dict[str, Any]) -> Foreseen:
    """Return where the command would lead from `joints` (rad), at rest. Raises BadRequest, OutOfWorkspace.

    What a step of a program lacks is its judgement.
    """
    bounded(kind, args)
    arm = load("pa10")
    here = start(joints, posture(arm, "ready"))
    if kind == "program":
        return preview(courses(settings), steps_of(args), here, numbered=True)
    if kind not in PLACES and f"{kind}_deg" not in arm["arm"]:
        raise BadRequest(f"There is no path to show for the command {kind}: it leads to no place.")
    return preview(courses(settings), [request_of(kind, args)], here, numbered=False)


def start(joints: tuple[float, ...], ready: Joints) -> Joints:
    """Return the joints (rad) at which a preview starts; missing ones are as at `ready`. Raises BadRequest."""
    if not isinstance(joints, tuple | list) or len(joints) > 2 * len(ready):
        raise BadRequest("The present joints must be a list of angles.")
    told = [number({"joint": value}, "joint") for value in joints[: len(ready)]]
    if any(abs(value) > FARTHEST_RAD for value in told):
        raise BadRequest(f"Each of the present joints must lie between -{FARTHEST_RAD:g} and {FARTHEST_RAD:g} rad.")
    return np.array([*told, *ready[len(told) :]])


def preview(courses: Courses, steps: list[Request], here: Joints, numbered: bool) -> Foreseen:
    """Return the path through `steps` from rest at `here` (rad); `numbered`: the steps are those of a program.

    A program of which a step cannot be done, or that lasts or costs too much, has a judgement that refuses it.

    Raises:
        OutOfWorkspace: the same of a command that is no program.

    """
    parts, steps_of, seconds = [here[None]], [0], 0.0
    said: tuple[Judgement, ...] = ()
    try:
        for step, path in courses.along(steps, here):
            count = max(2, int(path.seconds / BETWEEN_S))
            parts.append(path.sample(path.seconds * np.arange(1, count + 1) / count))
            steps_of += [step] * count
            seconds += path.seconds
        seconds += courses.pauses(steps)
    except StepRefused as error:
        if not numbered:
            raise OutOfWorkspace(f"The arm cannot go there: {error.why}.") from error
        said = (Judgement(error.step, error.at_s, f"Step {error.step}: {error.why}."),)
        seconds = error.at_s
    q = np.concatenate(parts)
    tool = courses.planner.chain.forward(q)[:, :3, 3]
    rows = tuple(tuple(row) for row in q.tolist())
    return Foreseen(
        rows[-1], rows, tuple(tuple(row) for row in tool.tolist()), seconds, tuple(steps_of) if numbered else (),
        judgements=said,
    )  # fmt: skip
