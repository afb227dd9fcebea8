"""What a person may ask over the socket; each calls the same services as the pages do."""

from dataclasses import dataclass, field
from typing import Any

from portal.live.people import current_user
from queueing import services as queue
from queueing.errors import QueueError
from robots import services
from robots.clock import SYSTEM
from robots.drivers.errors import BadRequest, NotPermitted, RobotError
from robots.drivers.values import number
from robots.models import Robot


@dataclass(frozen=True)
class Answer:
    """What became of a request."""

    ok: bool = True
    text: str = ""
    code: str = ""
    changed: bool = False
    trace: bool | None = None
    extra: dict[str, Any] = field(default_factory=dict)

    def fields(self) -> dict[str, Any]:
        """Return what the browser is told."""
        return {"ok": self.ok, "text": self.text, "code": self.code, **self.extra}


def act(scope: dict[str, Any], slug: str, message: dict[str, Any]) -> Answer:
    """Carry out one message. The person, their session and their turn are checked anew."""
    user = current_user(scope)
    if not user.is_authenticated:
        return Answer(False, "Sign in first.", "signed_out")
    try:
        if message.get("t") == "command":
            return _command(slug, user, message)
        return _act(Robot.objects.only("slug").get(slug=slug), user, message)
    except (RobotError, QueueError) as error:
        return Answer(False, str(error), error.code, changed=True)


def _command(slug: str, user: Any, message: dict[str, Any]) -> Answer:
    """Issue a command; the robot comes with its grant, in one query."""
    args = message.get("args") or {}
    row = services.issue(slug, user, _text(message, "kind"), args, _sequence(message), SYSTEM.now()).command
    return Answer(extra={"id": row.pk, "state": row.state, "grant": row.grant_id})


def _act(robot: Robot, user: Any, message: dict[str, Any]) -> Answer:
    now = SYSTEM.now()
    match message.get("t"):
        case "stop":
            services.stop(robot, user, now, rung=message.get("rung") is True)
            return Answer(text="Stop was sent.")
        case "release":
            services.release_stop(robot, user, message.get("checked") is True)
            return Answer(text="The stop is released. Nothing moves until you give a command.")
        case "join":
            queue.join(robot, user, now)
            return Answer(changed=True)
        case "leave":
            queue.leave(robot, user, now)
            return Answer(changed=True)
        case "accept":
            queue.accept(robot, user, now)
            return Answer(changed=True)
        case "trace":
            if not user.has_perm("robots.change_robot"):
                raise NotPermitted("The live trace is for keepers.")
            return Answer(trace=message.get("on") is True)
        case _:
            raise BadRequest("That request is unknown; reload the page.")


def plan(scope: dict[str, Any], slug: str, message: dict[str, Any]) -> dict[str, Any]:
    """Answer where a target would lead: joints at its end, way of the hand, time on the way."""
    args, joints = message.get("args") or {}, message.get("from")
    try:
        if not isinstance(args, dict):
            raise BadRequest("The values of a command must be an object.")
        if not isinstance(joints, list) or len(joints) > 16:
            raise BadRequest("The present joints must be a list of numbers.")
        here = tuple(number({"from": joint}, "from") for joint in joints)
        robot = Robot.objects.only("slug", "driver", "address", "speed", "boxes").get(slug=slug)
        found = services.preview(robot, current_user(scope), _text(message, "kind"), args, here)
    except RobotError as error:
        return {"ok": False, "text": str(error)}
    return {
        "ok": True, "text": "", "joints": found.joints, "seconds": round(found.seconds, 2),
        "hand": [[round(v, 4) for v in place] for place in found.hand],
        "ways": [[round(v, 4) for v in q] for q in found.ways], "steps": found.steps,
    }  # fmt: skip


def _text(message: dict[str, Any], name: str) -> str:
    value = message.get(name)
    if not isinstance(value, str) or len(value) > 30:
        raise BadRequest("The command has no proper name.")
    return value


def _sequence(message: dict[str, Any]) -> int:
    value = message.get("seq")
    if isinstance(value, bool) or not isinstance(value, int) or not 0 < value < 2**53:
        raise BadRequest("The command has no proper sequence number.")
    return value
