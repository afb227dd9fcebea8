"""What a robot does now, in the words that pages, cards and lists say of it."""

from datetime import datetime

from robots.dates import length_words
from robots.grants import lease_of, open_grant, owner_alive
from robots.models import Robot
from robots.sentences import english
from robots.services.lockout import note_said
from robots.states import Cycle, GrantKind

STAFF_COMMAND = (
    "handover", "Staff command running", "Staff run a command now; the robot is offered again after that.",
)  # fmt: skip
STOPPED = "Stopped. Release needs a look at the picture."
TIDIES = "The robot tidies up for the next turn: it brings back what is elsewhere, which takes at most {most}."
BY_ITSELF = {
    GrantKind.UPKEEP: (
        "handover",
        "Looking after itself",
        "The robot does something that it needs, such as recharging.",
    ),
    GrantKind.JOB: ("operating", "A job runs", "The robot does a job that somebody asked for."),
    GrantKind.IDLE: ("ready", "Moves by itself", ""),
    GrantKind.REST: ("handover", "Comes to rest", "The robot comes to rest; then it is offered again."),
}


def status_of(robot: Robot, now: datetime) -> tuple[str, str, str]:
    """Return (state, label, reason) of a robot as English text; a robot whose worker is silent is offline."""
    if not robot.enabled:
        return "offline", "Switched off", "Staff have switched this robot off."
    if robot.cycle == Cycle.LOCKED_OUT:
        note = robot.lockout_note
        return "locked_out", "Locked out", note_said(note) if note else "Staff are working on it."
    if not owner_alive(lease_of(robot), now):
        return "offline", "Offline", "Its worker does not answer and is restarted automatically. Places are kept."
    if robot.cycle == Cycle.FAULT or robot.reason:
        return "fault", "Faulty", robot.reason or "It is being looked after."
    if robot.stop_latched:
        return "stopped", "Stopped", STOPPED
    grant = open_grant(robot) if robot.cycle in (Cycle.READY, Cycle.OFFERED) else None
    if grant is not None and grant.kind in BY_ITSELF:
        return BY_ITSELF[GrantKind(grant.kind)] if grant.holder_id is None else STAFF_COMMAND
    return robot.cycle, english(Cycle(robot.cycle).label), _tidies(robot) if robot.cycle == Cycle.HANDOVER else ""


def _tidies(robot: Robot) -> str:
    """Return what a handover brings back, and how long that may take; empty for a robot that tidies nothing then."""
    longest_s = robot.tidying_s()
    return TIDIES.format(most=length_words(longest_s)) if longest_s >= 1.0 else ""
