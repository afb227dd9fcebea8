"""Checks and previews of a command of the museum arm before anything is sent; pure functions."""

from typing import Any

from robots.kit.arms.commands import TARGETS, bounded, check_target, motion_of, motion_planner
from robots.kit.arms.motions import MotionPlanner
from robots.kit.arms.objects import objects_of
from robots.kit.arms.preview import foresee as foresee_motions
from robots.kit.arms.tasks.requests import FORESEEN, TASK, Packets, check_job, check_request, foresee_task
from robots.kit.contract.capabilities import Foreseen
from robots.kit.contract.errors import BadRequest
from robots.kit.contract.session import RobotState
from robots.kit.drivers.pa10.protocol import LONGEST_PROGRAM_S, Malformed, Request
from robots.kit.drivers.pa10.protocol import program as parse_program
from robots.kit.drivers.pa10.units import motion_request, step_of


def planner_for(settings: dict[str, Any]) -> MotionPlanner:
    """Return the planner for the arm with these settings."""
    return motion_planner("pa10", LONGEST_PROGRAM_S, settings)


def check(kind: str, args: dict[str, Any], settings: dict[str, Any], state: RobotState | None) -> None:
    """Refuse unknown kinds, bad values, and targets outside limits, reach or in a box.

    Raises:
        BadRequest, OutOfWorkspace.

    """
    bounded("pa10", kind, args)
    check_request(objects_of("pa10"), kind, args)
    if kind == "program":
        steps_of(args)
    if kind in TARGETS:
        check_target(planner_for(settings), kind, args, state)


def check_task_job(kind: str, args: dict[str, Any], packets: Packets) -> None:
    """Refuse a task as a job that cannot be done. Raises BadRequest, OutOfWorkspace."""
    if kind == TASK:
        check_job(planner_for({}), objects_of("pa10"), args, packets)


def foresee(
    kind: str, args: dict[str, Any], joints: tuple[float, ...], settings: dict[str, Any], packets: Packets = ()
) -> Foreseen:
    """Return where the command would lead from `joints` (rad), at rest. Raises BadRequest, OutOfWorkspace."""
    bounded("pa10", kind, args)
    if kind in FORESEEN:
        return foresee_task(planner_for(settings), objects_of("pa10"), kind, args, joints, packets)
    program = [step_of(request) for request in steps_of(args)] if kind == "program" else None
    return foresee_motions(planner_for(settings), kind, args, joints, program)


def steps_of(args: dict[str, Any]) -> list[Request]:
    """Return the steps of a program given as text; none for one that is stored in the controller. Raises BadRequest."""
    if ("text" in args) == ("number" in args):
        raise BadRequest("A program is given by its number or as a text.")
    if "number" in args:
        return []
    try:
        steps = parse_program(args["text"])
    except Malformed as error:
        raise BadRequest(f"The program is not valid: {error}.") from error
    if not steps:
        raise BadRequest("The program has no step.")
    return steps


def request_of(kind: str, args: dict[str, Any]) -> Request:
    """Return the controller's request for a command that leads to a position."""
    return motion_request(motion_of("pa10", kind, args))
