"""Translates a click in a picture or a saved program into a command of the robot."""

from typing import Any

from robots.grants import ROBOT
from robots.kit.contract.capabilities import ClickInPicture, PictureTaken
from robots.kit.contract.channels import Pose
from robots.kit.contract.errors import BadRequest
from robots.kit.contract.find import function
from robots.models import Frame, Lease, Robot
from robots.prepared import Prepared
from robots.services import programs

MOVED = "The robot has moved since that picture; click in the newest one."
_NEWEST: Prepared[Frame] = Prepared(lambda: Frame.objects.filter(robot=ROBOT).order_by("-id")[:1])


def newest_still(robot: Robot) -> Frame | None:
    """Return the newest stored picture."""
    return _NEWEST.first(robot=robot.pk)


def resolve(
    robot: Robot, user: Any, kind: str, args: dict[str, Any], again: bool = False
) -> tuple[str, dict[str, Any]]:
    """Return the command for a click, by the robot's own rule, or for a saved program.

    `again`: the click was carried out already, so its picture need not be the newest.

    Raises:
        BadRequest: unknown or old picture, a point outside it, or the robot's rule refuses it.
    """
    spec = robot.spec()
    clicks = spec.capability(ClickInPicture)
    args = with_program(robot, user, kind, args)
    if clicks is None or kind != clicks.kind:
        return kind, args
    frame = Frame.objects.filter(robot=robot, pk=_integer(args, "still")).first()
    if frame is None:
        raise BadRequest("That picture is unknown; wait for the next one and click there.")
    newest = None if again else newest_still(robot)
    if not again and (newest is None or newest.pk != frame.pk):
        raise BadRequest(MOVED)
    if not again and _left(robot, spec.pose, clicks, frame):
        raise BadRequest(MOVED)
    u, v = _real(args, "u"), _real(args, "v")
    if not (0 <= u <= frame.width - 1 and 0 <= v <= frame.height - 1):
        raise BadRequest("That point lies outside the picture.")
    picture = PictureTaken(frame.width, frame.height, tuple(frame.joints), tuple(frame.pose), frame.calibration)
    found: tuple[str, dict[str, Any]] = function(clicks.resolve)(picture, u, v)
    return found


def with_program(robot: Robot, user: Any, kind: str, args: dict[str, Any]) -> dict[str, Any]:
    """Return the values of a command, with the text of the saved program in place of its number.

    Raises BadRequest: the person (None for a guest) may see no such program.
    """
    if "program" not in args or not programs.is_program(robot, kind):
        return args
    return {"text": programs.visible_program(robot, user, _integer(args, "program"), kind).text}


def _left(robot: Robot, pose: Pose | None, clicks: ClickInPicture, frame: Frame) -> bool:
    """Return whether the robot has moved away since the picture; False if that is not known."""
    lease = Lease.objects.filter(robot=robot, state_at__gt=frame.taken_at).first() if pose is not None else None
    now = lease.state.get("pose") if lease is not None else None
    if pose is None or not now or len(now) != len(pose.coordinates) or len(frame.pose) != len(now):
        return False
    m, rad = pose.apart(frame.pose, now)
    return m > clicks.apart_m or rad > clicks.apart_rad


def _integer(args: dict[str, Any], name: str) -> int:
    value = args.get(name)
    if isinstance(value, bool) or not isinstance(value, int) or abs(value) >= 2**63:
        raise BadRequest(f"The value {name} must be a whole number.")
    return value


def _real(args: dict[str, Any], name: str) -> float:
    value = args.get(name)
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < 1e9:
        raise BadRequest(f"The value {name} must be a number.")
    return float(value)
