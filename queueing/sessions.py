"""What becomes of a place and a turn when its person signs out, or may no longer drive."""

from datetime import datetime
from enum import Enum

from queueing.models import OPEN_TICKET, Ticket, Turn
from queueing.tickets import remove
from queueing.turns import end_turn
from robots.states import GrantEnd


class Place(Enum):
    """What becomes of a person's place and turn when a session of theirs ends."""

    KEPT = "kept"
    OTHERS = "goes on only where another session of theirs drives"
    TURN_ENDS = "the turn ends, a place in the queue is kept"
    LOST = "both are lost"


def disconnect(slug: str, person: int, now: datetime) -> None:
    """Mark the person's turn on the robot as one whose line is gone."""
    turns = Turn.objects.filter(robot__slug=slug, user=person, ended_at=None, classic=False)
    turns.update(connected=False, last_seen=now)


def session_over(slug: str, person: int, place: Place, reason: str, now: datetime) -> None:
    """End the person's turn on the robot, or take them out of its queue, as `place` says.

    With `OTHERS` the turn is to have been marked as disconnected a moment before: whoever still
    drives has said so since.
    """
    if place is Place.LOST:
        ticket = Ticket.objects.filter(queue__robot_links__robot__slug=slug, user=person, state__in=OPEN_TICKET).first()
        if ticket is not None:
            remove(ticket, now, reason, GrantEnd.ABSENT)
        return
    turns = Turn.objects.filter(robot__slug=slug, user=person, ended_at=None)
    if place is Place.OTHERS:
        turns = turns.filter(classic=False, connected=False)
    turn = turns.first() if place is not Place.KEPT else None
    if turn is not None:
        end_turn(turn, GrantEnd.ABSENT, reason, now)
