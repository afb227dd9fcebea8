"""The end of a turn or a place as pages show it; the words stand in `words.py`."""

from datetime import datetime, timedelta
from typing import Any

from django.conf import settings

from queueing.models import PlaceEnd, Ticket, TicketState, Turn
from queueing.turns import idle_s
from queueing.words import OWN_WISH, PLACE_ENDS, TURN_ENDS, End
from robots.dates import length_words
from robots.models import Robot
from robots.states import GrantEnd

RULES = settings.FARHAND
LATELY = timedelta(hours=1)  # all pages mention an end for this time


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
    """Return the words for a place that its person lost; None for a place that is open or was given up."""
    if ticket.state == TicketState.DONE:
        turn = getattr(ticket, "turn", None)
        own = turn is None or turn.ended_at is None or turn.grant.end_code == GrantEnd.HOLDER
        return None if own or turn is None else end_of_turn(turn)
    if ticket.state not in (TicketState.LEFT, TicketState.EXPIRED) or ticket.end_reason not in PlaceEnd.values:
        return None
    return None if ticket.end_reason in OWN_WISH else PLACE_ENDS[PlaceEnd(ticket.end_reason)]


def last_turn(robot: Robot, user: Any) -> Turn | None:
    """Return the person's last turn on the robot, if it has ended."""
    mine = Turn.objects.filter(user=user, robot=robot).exclude(ended_at=None)
    return mine.select_related("grant", "user").order_by("-id").first()


def is_news(turn: Turn, now: datetime) -> bool:
    """Return whether the turn ended so lately that all pages mention it."""
    return turn.ended_at is not None and now - turn.ended_at < LATELY
