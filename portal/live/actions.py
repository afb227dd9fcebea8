"""Requests over the robot's socket; they call the same services as the pages."""

from dataclasses import dataclass, field
from typing import Any

from portal.live.messages import Accept, Command, Join, Leave, Release, RobotMessage, Stop, Trace
from portal.live.people import current_user, session_key
from queueing import services as queue
from queueing.errors import QueueError
from robots import services
from robots.kit.clock import SYSTEM
from robots.kit.contract.errors import BadRequest, NotPermitted, RobotError
from robots.models import Robot
from robots.states import GrantKind


@dataclass(frozen=True)
class Answer:
    """The result of a request."""

    ok: bool = True
    text: str = ""
    code: str = ""
    changed: bool = False
    trace: bool | None = None
    new_command: int = 0  # the key of a command that this request wrote; 0 for one that another had written
    extra: dict[str, Any] = field(default_factory=dict)

    def fields(self) -> dict[str, Any]:
        """Return the JSON fields for the browser."""
        return {"ok": self.ok, "text": self.text, "code": self.code, **self.extra}


SIGN_IN = Answer(False, "Sign in first.", "signed_out")


def act(scope: dict[str, Any], slug: str, message: RobotMessage, sent: bool = False) -> Answer:
    """Carry out one message, with person, session and turn checked again.

    `sent`: the stop was sent over the bus already.
    """
    user = current_user(scope)
    if not user.is_authenticated:
        return SIGN_IN
    try:
        if isinstance(message, Command):
            return _command(slug, user, message)
        return _act(Robot.objects.only("slug").get(slug=slug), user, message, sent, session_key(scope))
    except (RobotError, QueueError) as error:
        return Answer(False, str(error), error.code, changed=True)


def _drives_for_maintenance(robot: Robot, user: Any) -> bool:
    grant = services.open_grant(robot)
    return grant is not None and grant.kind == GrantKind.STAFF and grant.holder_id == user.pk


def _command(slug: str, user: Any, message: Command) -> Answer:
    """Issue a command; the robot comes with its grant, in one query."""
    issued = services.issue(slug, user, message.kind, dict(message.args), message.seq, SYSTEM.now(), message.seen)
    row = issued.command
    return Answer(
        new_command=row.pk if issued.created else 0, extra={"id": row.pk, "state": row.state, "grant": row.grant_id}
    )


def _act(robot: Robot, user: Any, message: RobotMessage, sent: bool, session: str) -> Answer:
    now = SYSTEM.now()
    match message:
        case Stop():
            services.stop(robot, user, now, sent=sent)
            queue.note_act(robot, user, now)
            return Answer(text="Stop was sent.")
        case Release():
            services.release_stop(robot, user, message.checked)
            queue.note_act(robot, user, now)
            return Answer(text="The stop is released. Nothing moves until you give a command.")
        case Leave() if _drives_for_maintenance(robot, user):
            services.end_maintenance(robot, user)
            return Answer(text="The maintenance turn is over. The robot stays locked out.", changed=True)
        case Join() | Leave() | Accept():
            queue.change_place(str(message.__struct_config__.tag), robot, user, now, queue.Page(session))
            return Answer(changed=True)
        case Trace():
            if not user.has_perm("robots.change_robot"):
                raise NotPermitted("The live trace is for staff.")
            return Answer(trace=message.on)
        case _:
            raise BadRequest("That request is unknown; reload the page.")
