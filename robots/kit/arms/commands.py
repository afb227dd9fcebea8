"""Commands of an arm that its files describe: `joints`, `pose`, `line`, and one for each posture of `[arm]`.

`joints` has an argument for each joint (rad), `pose` and `line` those of `PLACE` (m, rad); `speed` is optional.
"""

from functools import lru_cache
from typing import Any

import numpy as np

from robots.kit.arms.boxes import added_boxes
from robots.kit.arms.chain import Joints
from robots.kit.arms.described import chain, posture
from robots.kit.arms.motions import Motion, MotionPlanner
from robots.kit.arms.planner import Refused
from robots.kit.arms.pose import Six, matrix
from robots.kit.arms.zones import Box
from robots.kit.contract.channels import IN_SPACE
from robots.kit.contract.errors import OutOfWorkspace
from robots.kit.contract.find import spec_of
from robots.kit.contract.session import RobotState
from robots.kit.contract.values import known_command, number, within
from robots.kit.description import load

PLACE = IN_SPACE.coordinates
TARGETS = ("pose", "line", "joints")  # kinds of commands whose arguments name a position


@lru_cache(16)
def _planner(driver: str, longest_program_s: float, extra: tuple[Box, ...]) -> MotionPlanner:
    return MotionPlanner(driver, longest_program_s, extra)


def motion_planner(driver: str, longest_program_s: float, settings: dict[str, Any]) -> MotionPlanner:
    """Return the planner for the arm with these settings; cached, because creating one is slow."""
    return _planner(driver, longest_program_s, added_boxes(settings))


def motion_of(driver: str, kind: str, args: dict[str, Any]) -> Motion:
    """Return the motion of a command that leads to a position. Raises BadRequest."""
    scale = number(args, "speed") if "speed" in args else None
    if kind in ("pose", "line"):
        x, y, z, roll, pitch, yaw = (number(args, name) for name in PLACE)
        six: Six = x, y, z, roll, pitch, yaw
        return Motion(pose=six, straight=kind == "line", scale=scale)
    if kind == "joints":
        return Motion(tuple(number(args, name) for name in chain(driver).names), scale=scale)
    target: Joints = posture(load(driver), kind)
    return Motion(tuple(target), scale=scale)


def bounded(driver: str, kind: str, args: dict[str, Any]) -> None:
    """Refuse unknown kinds and values outside their range; the planner names joint limits. Raises BadRequest."""
    command = known_command(spec_of(driver), kind, args)
    within(command, {k: v for k, v in args.items() if k == "speed" or kind != "joints"})


def check_target(planner: MotionPlanner, kind: str, args: dict[str, Any], state: RobotState | None) -> None:
    """Refuse a position of `TARGETS` outside limits, reach or in a box; `state` is the newest, if it is known.

    Raises:
        BadRequest, OutOfWorkspace.

    """
    motion, arm = motion_of(planner.driver, kind, args), planner.planner
    try:
        if motion.pose is None:
            arm.stand(np.array(motion.joints))
        else:
            ready = posture(load(planner.driver), "ready")
            near = arm.chain.joints_in(state.joints) if state else ready
            arm.stand(arm.reach(matrix(motion.pose), near))
    except Refused as error:
        raise OutOfWorkspace(f"The arm cannot go there: {error}.") from error
