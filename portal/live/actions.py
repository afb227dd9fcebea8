"""What a person may ask over the socket; each calls the same services as the pages do."""

from dataclasses import dataclass, field
from typing import Any

from django.db import InterfaceError, OperationalError

from portal.live.people import current_user
from queueing import services as queue
from queueing.errors import QueueError
from robots import services
from robots.clock import SYSTEM
from robots.drivers.errors import BadRequest, NotPermitted, RobotError
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
        robot = Robot.objects.only("slug").get(slug=slug)
        return _act(robot, user, message)
    except (RobotError, QueueError) as error:
        return Answer(False, str(error), error.code, changed=True)
    except (OperationalError, InterfaceError):
        return Answer(False, "The database does not answer; nothing was done. Try again in a moment.", "store_down")


def _act(robot: Robot, user: Any, message: dict[str, Any]) -> Answer:
    now = SYSTEM.now()
    match message.get("t"):
        case "command":
            issued = services.issue(
                robot, user, _text(message, "kind"), message.get("args") or {}, _sequence(message), now
            )
            return Answer(
                extra={"id": issued.command.pk, "state": issued.command.state, "grant": issued.command.grant_id}
            )
        case "stop":
            services.stop(robot, user, now)
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
