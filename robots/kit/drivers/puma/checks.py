"""Checks and previews of a command of the PUMA 560 before anything is sent; pure functions."""

from typing import Any

from robots.kit.arms.commands import TARGETS, bounded, check_target, motion_planner
from robots.kit.arms.motions import MotionPlanner
from robots.kit.arms.objects import objects_of
from robots.kit.arms.preview import foresee as foresee_motions
from robots.kit.arms.tasks.requests import FORESEEN, TASK, Packets, check_job, check_request, foresee_task
from robots.kit.contract.capabilities import Foreseen
from robots.kit.contract.session import RobotState

LONGEST_TASK_S = 900.0


def planner_for(settings: dict[str, Any]) -> MotionPlanner:
    """Return the planner for the arm with these settings."""
    return motion_planner("puma", LONGEST_TASK_S, settings)


def check(kind: str, args: dict[str, Any], settings: dict[str, Any], state: RobotState | None) -> None:
    """Refuse unknown kinds, bad values, and targets outside limits, reach or in a box.

    Raises:
        BadRequest, OutOfWorkspace.

    """
    bounded("puma", kind, args)
    check_request(objects_of("puma"), kind, args)
    if kind in TARGETS:
        check_target(planner_for(settings), kind, args, state)


def check_task_job(kind: str, args: dict[str, Any], packets: Packets) -> None:
    """Refuse a task as a job that cannot be done. Raises BadRequest, OutOfWorkspace."""
    if kind == TASK:
        check_job(planner_for({}), objects_of("puma"), args, packets)


def foresee(
    kind: str, args: dict[str, Any], joints: tuple[float, ...], settings: dict[str, Any], packets: Packets = ()
) -> Foreseen:
    """Return where the command would lead from `joints` (rad), at rest. Raises BadRequest, OutOfWorkspace."""
    bounded("puma", kind, args)
    if kind in FORESEEN:
        return foresee_task(planner_for(settings), objects_of("puma"), kind, args, joints, packets)
    return foresee_motions(planner_for(settings), kind, args, joints)
