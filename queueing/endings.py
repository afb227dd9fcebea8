"""What pages tell of the end of a turn or a place: why it ended, what it costs, and what its person can do next."""

from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import Any

from django.conf import settings

from queueing.models import PlaceEnd, Ticket, TicketState, Turn
from queueing.turns import idle_s
from queueing.words import length_words
from robots.models import Robot
from robots.states import GrantEnd

RULES = settings.FARHAND
LATELY = timedelta(hours=1)  # for so long an end is told on pages that are not about it


@dataclass(frozen=True)
class End:
    """The words of one kind of end. `{used}`, `{idle}`: lengths of time; credit is what `charging` does."""

    why: str
    credited: str
    next: str


WHOLE = "It counts as {used} of use."
CUT = "Only the {used} that you had count as use; the rest of the turn costs you nothing. No place is kept for you."
FREE = "It costs you nothing."
JOIN = "You can join the queue again."
LATER = "You can join the queue now; it goes on when staff open the robot again."
ASK = "You cannot join the queue until staff allow it; ask them."

TURN_ENDS: dict[GrantEnd, End] = {
    GrantEnd.FINISHED: End("It was ended.", WHOLE, JOIN),
    GrantEnd.FAILED: End("The robot failed.", CUT, JOIN),
    GrantEnd.TIME_UP: End("Its time was up.", WHOLE, JOIN),
    GrantEnd.HOLDER: End("You ended it.", WHOLE, JOIN),
    GrantEnd.STAFF: End("Staff ended it.", CUT, JOIN),
    GrantEnd.ABSENT: End("The robot's page had no connection to the portal for {reconnect}.", CUT, JOIN),
    GrantEnd.IDLE: End("Nothing was done for {idle} while others waited.", CUT, JOIN),
    GrantEnd.SILENT: End("The console without scripts sent nothing for {silent}.", CUT, JOIN),
    GrantEnd.SIGNED_OUT: End("You were signed out, here or in another browser.", CUT, JOIN),
    GrantEnd.UNFIT: End("Your account or your clearance for this robot was withdrawn.", CUT, ASK),
    GrantEnd.STOPPED: End("The robot was stopped.", CUT, JOIN),
    GrantEnd.LOCKED_OUT: End("Staff closed the robot to everybody.", CUT, LATER),
    GrantEnd.SWITCHED_OFF: End(
        "Staff switched the robot off.", CUT, "You can join the queue when the robot is switched on again."
    ),
    GrantEnd.OWNER_LOST: End("The robot's program was interrupted.", CUT, JOIN),
    GrantEnd.PREEMPTED: End("Staff needed the robot.", CUT, JOIN),
    GrantEnd.RESTORED: End("The portal was restored from a backup.", CUT, JOIN),
}
PLACE_ENDS: dict[PlaceEnd, End] = {
    PlaceEnd.NO_ANSWER: End("You did not take control in time, so your place is gone.", FREE, JOIN),
    PlaceEnd.AWAY: End("You were away for too long, so your place is gone.", FREE, JOIN),
    PlaceEnd.LEFT: End("You left the queue.", FREE, JOIN),
    PlaceEnd.REMOVED: End("Staff took you out of the queue.", FREE, JOIN),
    PlaceEnd.SUSPENDED: End("Your account was switched off.", FREE, ASK),
    PlaceEnd.UNCLEARED: End("Your clearance for this robot was withdrawn.", FREE, ASK),
}
OWN_WISH = (GrantEnd.HOLDER, PlaceEnd.LEFT)  # whoever wanted it need not be told


def end_of_turn(turn: Turn) -> End:
    """Return the words for an ended turn."""
    end = TURN_ENDS[GrantEnd(turn.grant.end_code or GrantEnd.FINISHED)]
    lengths = {
        "used": length_words(turn.charged_s or 0.0), "idle": length_words(idle_s(turn)),
        "reconnect": length_words(RULES["RECONNECT_S"]), "silent": length_words(RULES["CLASSIC_PRESENCE_S"]),
    }  # fmt: skip
    credited = end.credited
    if turn.alone_s:
        credited += " Extra time, in which nobody waited, counts half."
    return End(end.why.format(**lengths), credited.format(**lengths), end.next)


def end_of_place(ticket: Ticket) -> End | None:
    """Return the words for a place that its person lost; None for one that is open, or that they gave up."""
    if ticket.state == TicketState.DONE:
        turn = getattr(ticket, "turn", None)
        own = turn is None or turn.ended_at is None or turn.grant.end_code == GrantEnd.HOLDER
        return None if own or turn is None else end_of_turn(turn)
    if ticket.state not in (TicketState.LEFT, TicketState.EXPIRED) or ticket.end_reason not in PlaceEnd.values:
        return None
    return None if ticket.end_reason in OWN_WISH else PLACE_ENDS[PlaceEnd(ticket.end_reason)]


def last_turn(robot: Robot, user: Any) -> Turn | None:
    """Return the person's last turn on the robot, if it has ended."""
    return user.turns.select_related("grant").filter(robot=robot).exclude(ended_at=None).order_by("-id").first()


def is_news(turn: Turn, now: datetime) -> bool:
    """Return whether the turn ended so lately that pages which are not about it tell of it."""
    return turn.ended_at is not None and now - turn.ended_at < LATELY
