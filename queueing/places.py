"""A person's places at all robots. Reads only."""

from dataclasses import dataclass, replace
from datetime import datetime, timedelta
from typing import Any

from django.conf import settings
from django.db.models import Exists, OuterRef

from queueing.estimates import place_and_wait
from queueing.models import OPEN_TICKET, Ticket, TicketState
from robots.models import Robot

RULES = settings.FARHAND
URGENT_FIRST = ("offered", "operating", "missed", "waiting")


@dataclass(frozen=True)
class Standing:
    """A person's place at one robot: `offered`, `operating`, `waiting`, or `missed` and not dismissed yet."""

    state: str
    ticket: int
    queue: int
    robot: Robot
    until: datetime | None = None  # when the offer or the turn ends
    kept_until: datetime | None = None  # when the turn ends unless its robot's page is opened again
    ahead: int = 0
    wait_s: tuple[int, int] | None = None
    ended_at: datetime | None = None
    reason: str = ""


def standings(user: Any, now: datetime) -> list[Standing]:
    """Return the person's places at all robots, the most urgent first."""
    if user is None or not user.is_authenticated:
        return []
    newer = Ticket.objects.filter(queue=OuterRef("queue"), user=OuterRef("user"), pk__gt=OuterRef("pk"))
    mine = Ticket.objects.filter(user=user).select_related("robot", "turn").order_by("pk")
    missed = mine.filter(state=TicketState.EXPIRED, dismissed_at=None).exclude(Exists(newer))
    found = [_standing(ticket, now) for ticket in (*mine.filter(state__in=OPEN_TICKET), *missed)]
    return sorted((s for s in found if s is not None), key=_urgency)


def _urgency(one: Standing) -> tuple[int, float, int]:
    end = one.until.timestamp() if one.until else 0.0
    return URGENT_FIRST.index(one.state), end, one.ahead


def _standing(ticket: Ticket, now: datetime) -> Standing | None:
    robot = ticket.robot or Robot.objects.filter(queue_link__queue=ticket.queue_id).order_by("pk").first()
    if robot is None:
        return None
    state = "missed" if ticket.state == TicketState.EXPIRED else str(ticket.state)
    found = Standing(state, ticket.pk, ticket.queue_id, robot)
    if state == "offered":
        return replace(found, until=ticket.offer_until)
    if state == "operating":
        turn, kept = getattr(ticket, "turn", None), None
        if turn is None:  # the robot was deleted
            return None
        if not turn.connected and not turn.classic:
            kept = min(turn.until, turn.last_seen + timedelta(seconds=RULES["RECONNECT_S"]))
        return replace(found, until=turn.until, kept_until=kept)
    if state == "missed":
        return replace(found, ended_at=ticket.ended_at, reason=ticket.end_reason)
    ahead, wait_s = place_and_wait(robot, ticket, now)
    return replace(found, ahead=ahead, wait_s=wait_s)
