"""Checks a command of the museum arm before anything is sent; pure functions."""

from functools import lru_cache
from typing import Any

import numpy as np

from robots.kit.arms.chain import Joints
from robots.kit.arms.described import boxes, chain, posture
from robots.kit.arms.planner import Refused
from robots.kit.arms.pose import Six, matrix
from robots.kit.arms.zones import Box
from robots.kit.contract.errors import BadRequest, OutOfWorkspace
from robots.kit.contract.find import spec_of
from robots.kit.contract.session import RobotState
from robots.kit.contract.values import known, number, within
from robots.kit.description import load
from robots.kit.drivers.pa10.courses import Courses
from robots.kit.drivers.pa10.protocol import Malformed, Request
from robots.kit.drivers.pa10.protocol import program as parse_program
from robots.kit.drivers.pa10.spec import PLACE
from robots.kit.drivers.pa10.units import joint_request, pose_request

PLACES = ("pose", "line", "joints")  # commands that name a position


def added_boxes(settings: dict[str, Any]) -> tuple[Box, ...]:
    """Return the forbidden boxes that staff have added to the arm's own (m)."""
    return boxes({"box": settings.get("boxes", ())})


@lru_cache(16)
def _courses(extra: tuple[Box, ...]) -> Courses:
    """Return a planner among the arm's own boxes and these; cached, because creating one is slow."""
    return Courses(extra)


def courses(settings: dict[str, Any]) -> Courses:
    """Return the planner for the arm with these settings."""
    return _courses(added_boxes(settings))


def check(kind: str, args: dict[str, Any], settings: dict[str, Any], state: RobotState | None) -> None:
    """Refuse unknown kinds, bad values, and targets outside limits, reach or in a box.

    Raises:
        BadRequest, OutOfWorkspace.

    """
    bounded(kind, args)
    if kind == "program":
        steps_of(args)
    if kind in PLACES:
        planner = courses(settings).planner
        try:
            if kind == "joints":
                planner.stand(np.array([number(args, name) for name in chain("pa10").names]))
            else:
                near = np.array(state.joints[:-1]) if state else posture(load("pa10"), "ready")
                planner.stand(planner.reach(matrix(_six(args)), near))
        except Refused as error:
            raise OutOfWorkspace(f"The arm cannot go there: {error}.") from error


def bounded(kind: str, args: dict[str, Any]) -> None:
    """Refuse unknown kinds and values outside their range; the planner names joint limits."""
    command = known(spec_of("pa10"), kind, args)
    within(command, {k: v for k, v in args.items() if k == "speed" or kind != "joints"})


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


def _six(args: dict[str, Any]) -> Six:
    x, y, z, roll, pitch, yaw = (number(args, name) for name in PLACE)
    return x, y, z, roll, pitch, yaw


def request_of(kind: str, args: dict[str, Any]) -> Request:
    """Return the controller's request for a command that leads to a position."""
    scale = number(args, "speed") if "speed" in args else None
    if kind in ("pose", "line"):
        return pose_request("k" if kind == "pose" else "l", _six(args), scale)
    if kind == "joints":
        return joint_request("j", tuple(number(args, name) for name in chain("pa10").names), scale)
    target: Joints = posture(load("pa10"), kind)
    return joint_request("j", tuple(target), scale)
