"""Checks a command of the Mercury arm, and each target of its tool, before a byte is sent; pure functions."""

from math import hypot, isfinite, radians
from typing import Any

from robots.kit.contract.errors import BadRequest, OutOfWorkspace
from robots.kit.contract.find import spec_of
from robots.kit.contract.floor import Floor
from robots.kit.contract.session import JSON, RobotState
from robots.kit.contract.values import known_command, number, within
from robots.kit.description import load
from robots.kit.drivers.mercury.scara import OutOfReach, scara

DOWN_M = 0.001
SLACK = 1e-6
FAR_M = 10.0  # beyond this the distance is not named


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
        raise BadRequest("A small step needs a direction.")
    if kind == "air" and state is not None and state.pose[2] > DOWN_M:
        raise BadRequest("Air works only while the arm is down: press Down first.")


def check_target(description: dict[str, Any], x: float, y: float, z: float) -> tuple[float, float, float, float]:
    """Return the joints (rad, m) for a tool target in m.

    Raises:
        BadRequest: a value is not finite.
        OutOfWorkspace: outside the height, the annulus, the sand area or a joint limit.
    """
    for name, value in (("x", x), ("y", y), ("z", z)):
        if not isfinite(value):
            raise BadRequest(f"The value {name} must be a finite number.")
    arm = scara(description)
    low, high = description["arm"]["q3"]
    if not low - SLACK <= z <= high + SLACK:
        raise OutOfWorkspace(f"Height {z * 1000:.0f} mm is outside {low * 1000:.0f} to {high * 1000:.0f} mm.")
    radius = hypot(x, y)
    if not arm.inner_radius <= radius <= arm.outer_radius:
        away = f"{radius * 1000:.0f} mm" if radius < FAR_M else f"more than {FAR_M:g} m"
        raise OutOfWorkspace(
            f"That point is {away} from the shoulder; the arm reaches "
            f"{arm.inner_radius * 1000:.0f} to {arm.outer_radius * 1000:.0f} mm."
        )
    for axis, value in (("x", x), ("y", y)):
        near, far = description["sand"][axis]
        if not near - SLACK <= value <= far + SLACK:
            raise OutOfWorkspace(
                f"That point is off the sand: {axis} would be {value * 1000:.0f} mm, the sand "
                f"goes from {near * 1000:.0f} to {far * 1000:.0f} mm."
            )
    try:
        return arm.inverse(x, y, min(max(z, low), high), radians(description["arm"]["theta_deg"]))
    except OutOfReach as error:
        raise OutOfWorkspace(f"The arm cannot reach that point: {error}.") from error


def floor_plan(_settings: JSON) -> Floor:
    """Return the table as plots show it: what the map of the classic console shows, and the sand."""
    described = load("mercury")
    (x0, x1), (y0, y1) = described["sand"]["x"], described["sand"]["y"]
    room = described["classic"]["map"]
    return Floor((room[0], room[1], room[2], room[3]), ((x0, y0, x1, y1),))
