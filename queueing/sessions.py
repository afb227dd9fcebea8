"""What happens to a place and a turn when their person signs out or may no longer drive."""

from datetime import datetime
from enum import Enum

from django.contrib.sessions.models import Session

from queueing.models import OPEN_TICKET, PlaceEnd, Ticket, Turn, TurnSession
from queueing.tickets import remove
from queueing.turns import end_turn
from robots.states import GrantEnd


class Place(Enum):
    """What happens to place and turn when a session of the person ends."""

    KEPT = "kept"
    OTHERS = "goes on only where another session of theirs drives"
    TURN_ENDS = "the turn ends, a place in the queue is kept"
    LOST = "both are lost"


def reported_elsewhere(slug: str, person: int, session: str, now: datetime) -> datetime | None:
    """Return when the operator's page last reported in another session of theirs that is not over; None if in none."""
    alive = Session.objects.filter(expire_date__gt=now).exclude(pk=session)
    mine = TurnSession.objects.filter(turn__robot__slug=slug, turn__user=person, turn__ended_at=None)
    found = mine.filter(session__in=alive.values("pk")).order_by("-last_seen").first()
    return found.last_seen if found else None


def still_open(person: int, session: str, now: datetime) -> None:
    """Note that a session in which the person's turn was accepted still has a page open, whichever page that is."""
    TurnSession.objects.filter(turn__user=person, turn__ended_at=None, session=session).update(last_seen=now)


def disconnect(slug: str, person: int, now: datetime) -> None:
    """Mark the person's turn on the robot as disconnected."""
    turns = Turn.objects.filter(robot__slug=slug, user=person, ended_at=None, classic=False)
    turns.update(connected=False, last_seen=now)


def session_over(slug: str, person: int, place: Place, reason: str, now: datetime) -> None:
    """End the person's turn on the robot, or remove them from its queue, as `place` says.

    With `OTHERS` the turn must have been marked as disconnected a moment before: another session that still drives has
    removed the mark since.
    """
    if place is Place.LOST:
        ticket = Ticket.objects.filter(queue__robot_links__robot__slug=slug, user=person, state__in=OPEN_TICKET).first()
        if ticket is not None:
            remove(ticket, now, PlaceEnd(reason), GrantEnd.UNFIT)
        return
    turns = Turn.objects.filter(robot__slug=slug, user=person, ended_at=None)
    if place is Place.OTHERS:
        turns = turns.filter(classic=False, connected=False)
    turn = turns.first() if place is not Place.KEPT else None
    if turn is not None:
        end_turn(turn, GrantEnd.SIGNED_OUT, reason, now)
