"""A person's places at all robots. It changes no row."""

from dataclasses import dataclass, replace
from datetime import datetime, timedelta
from typing import Any

from django.conf import settings
from django.db.models import DateTimeField, Exists, OuterRef, Q, QuerySet

from queueing.endings import LATELY, end_of_place
from queueing.estimates import place_and_wait
from queueing.models import OPEN_TICKET, PlaceEnd, Ticket, TicketState
from queueing.rows import links_of
from queueing.turns import USER, idle_at
from queueing.words import End
from robots.bus.web_uptime import up_since
from robots.models import Robot
from robots.prepared import Prepared, Slot

RULES = settings.FARHAND
URGENT_FIRST = ("offered", "operating", "missed", "ended", "waiting")


@dataclass(frozen=True)
class Standing:
    """A person's place at one robot: `offered`, `operating`, `waiting`; `missed` or `ended` until it is dismissed.

    A place that the person lost by absence is `missed`; any other that ended against their wish is `ended`.
    """

    state: str
    ticket: int
    queue: int
    robot: Robot
    until: datetime | None = None  # when the offer or the turn ends
    kept_until: datetime | None = None  # when the turn ends unless the robot's page is opened again
    idle_at: datetime | None = None  # when the turn ends unless something is done
    ahead: int = 0
    wait_s: tuple[int, int] | None = None
    ended_at: datetime | None = None
    away: bool = False
    end: End | None = None
    turn: int | None = None  # the turn that ended the place


SINCE = Slot("since", DateTimeField())
_OPEN: Prepared[Ticket] = Prepared(lambda: _mine().filter(state__in=OPEN_TICKET))
_LOST: Prepared[Ticket] = Prepared(lambda: _newest_over().filter(Q(state=TicketState.EXPIRED) | Q(ended_at__gt=SINCE)))


def _mine() -> QuerySet[Ticket]:
    return (
        Ticket.objects.filter(user=USER)
        .select_related("queue", "robot", "turn__grant", "turn__robot", "turn__user")
        .order_by("pk")
    )


def _newest_over() -> QuerySet[Ticket]:
    """Return the newest place in each queue if it has ended and was not dismissed."""
    newer = Ticket.objects.filter(queue=OuterRef("queue"), user=OuterRef("user"), pk__gt=OuterRef("pk"))
    return _mine().filter(dismissed_at=None).exclude(state__in=OPEN_TICKET).exclude(Exists(newer))


def standings(user: Any, now: datetime) -> list[Standing]:
    """Return the person's places at all robots, the most urgent first."""
    if user is None or not user.is_authenticated:
        return []
    found = [_standing(ticket, now) for ticket in (*_OPEN(user=user.pk), *_LOST(user=user.pk, since=now - LATELY))]
    return sorted((s for s in found if s is not None), key=_urgency)


def _urgency(one: Standing) -> tuple[int, float, int]:
    end = one.until.timestamp() if one.until else 0.0
    return URGENT_FIRST.index(one.state), end, one.ahead


def _standing(ticket: Ticket, now: datetime) -> Standing | None:
    robot = ticket.robot or next((link.robot for link in links_of(ticket.queue)), None)
    if robot is None:
        return None
    if ticket.state not in OPEN_TICKET:
        return _over(ticket, robot)
    state = str(ticket.state)
    found = Standing(state, ticket.pk, ticket.queue_id, robot)
    if state == "offered":
        return replace(found, until=ticket.offer_until)
    if state == "operating":
        turn, kept = getattr(ticket, "turn", None), None
        if turn is None:  # the robot was deleted
            return None
        if not turn.connected and not turn.classic:
            kept = min(turn.until, turn.last_seen + timedelta(seconds=RULES["RECONNECT_S"]))
        return replace(found, until=turn.until, kept_until=kept, idle_at=idle_at(turn, now, up_since(now)))
    ahead, wait_s = place_and_wait(robot, ticket, now)
    return replace(found, ahead=ahead, wait_s=wait_s)


def _over(ticket: Ticket, robot: Robot) -> Standing | None:
    end = end_of_place(ticket)
    if end is None:
        return None
    missed, turn = ticket.state == TicketState.EXPIRED, getattr(ticket, "turn", None)
    return Standing(
        "missed" if missed else "ended", ticket.pk, ticket.queue_id, robot if turn is None else turn.robot,
        ended_at=ticket.ended_at, away=missed and ticket.end_reason != PlaceEnd.NO_ANSWER, end=end,
        turn=turn.pk if turn is not None else None,
    )  # fmt: skip
