"""Checks a command of the Mercury arm before anything is sent; pure functions."""

from math import hypot
from typing import Any

from robots.kit.contract.errors import BadRequest
from robots.kit.contract.find import spec_of
from robots.kit.contract.session import RobotState
from robots.kit.contract.values import known_command, number, within
from robots.kit.description import load
from robots.kit.drivers.mercury.limits import check_target

DOWN_M = 0.001


def check(kind: str, args: dict[str, Any], settings: dict[str, Any], state: RobotState | None) -> None:
    """Refuse unknown kinds, bad values and targets outside the workspace.

    Raises:
        BadRequest, OutOfWorkspace.

    """
    command = known_command(spec_of("mercury"), kind, args)
    if kind != "move":  # its values are checked as a position
        within(command, args)
    if kind == "move":
        arm = load("mercury")
        z = state.pose[2] if state else float(arm["arm"]["up"])
        check_target(arm, number(args, "x"), number(args, "y"), z)
    if kind == "jog" and hypot(args["dx"], args["dy"]) < 0.1:
        raise BadRequest("A jog needs a direction.")
    if kind == "air" and state is not None and state.pose[2] > DOWN_M:
        raise BadRequest("Air works only at Z = 0: press Down first.")
