"""Acts of people on their own place, the same from every page: join, accept, leave, stay, be present, dismiss."""

from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime
from typing import Any

from django.db.models import QuerySet

from queueing.errors import NotYourTurn, QueueError
from queueing.models import NOT_YET, OPEN_TICKET, LostCause, Ticket, TicketState, Turn, TurnSession
from queueing.offers import accept
from queueing.tickets import join, leave, open_ticket
from queueing.turns import stay
from robots import bus
from robots.kit.packets import StandingChanged
from robots.models import Robot

MOST_LOST = 50  # connections of a turn that are listed


@dataclass(frozen=True)
class Page:
    """The page from which a person acts.

    `session`: the key of its session; `away`: not the robot's own page; `classic`: the console without scripts.
    """

    session: str = ""
    away: bool = False
    classic: bool = False


def _stay(robot: Robot, user: Any, now: datetime) -> None:
    if not stay(robot, user, now):
        raise NotYourTurn("Your turn on this robot is over.")


PLACE_ACTS: dict[str, Callable[[Robot, Any, datetime, Page], object]] = {
    "join": lambda robot, user, now, page: join(robot, user, now, classic=page.classic),
    "accept": lambda robot, user, now, page: accept(robot, user, now, away=page.away, session=page.session),
    "leave": lambda robot, user, now, _: leave(robot, user, now),
    "stay": lambda robot, user, now, _: _stay(robot, user, now),
}


def change_place(act: str, robot: Robot, user: Any, now: datetime, page: Page) -> None:
    """Carry out one of `PLACE_ACTS`. Raises QueueError, also for another act, with a sentence for the person."""
    if act not in PLACE_ACTS:
        raise QueueError("That request is unknown; reload the page.")
    PLACE_ACTS[act](robot, user, now, page)


def note_presence(robot: Robot, user: Any, now: datetime, classic: bool | None = None, session: str = "") -> None:
    """Note a heartbeat or a request, which came at `now`, as presence; `session`: the key of the page's session.

    Each socket of a page has its own thread, so a later absence may be stored already; it stays.
    """
    ticket = open_ticket(robot, user)
    if ticket is None:
        return
    changes: dict[str, Any] = {"last_seen": now}
    if classic is not None:
        changes["classic"] = classic
    Ticket.objects.filter(pk=ticket.pk).update(**changes)
    if ticket.state == TicketState.OPERATING:
        mine = Turn.objects.filter(ticket=ticket, ended_at=None)
        if session and (turn := mine.first()) is not None:
            TurnSession.objects.bulk_create(
                [TurnSession(turn=turn, session=session, last_seen=now)],
                update_conflicts=True, unique_fields=["turn", "session"], update_fields=["last_seen"],
            )  # fmt: skip
        back = mine.filter(connected=False, last_seen__lte=now).update(connected=True)
        mine.filter(connected=True).update(**changes)
        if back:
            bus.tell_people_on_commit(StandingChanged(user=user.pk))


def note_disconnection(robot: Robot, user: Any, now: datetime, session: str = "", cause: str = "") -> None:
    """Note that the operator's socket closed; the turn is kept for a while. `session`: its session's key.

    `cause`: why it closed, where that is known; it is listed on the page of the turn.
    """
    mine = Turn.objects.filter(robot=robot, user=user, ended_at=None, classic=False)
    TurnSession.objects.filter(turn__in=mine, session=session).delete()
    if mine.update(connected=False, last_seen=now):
        if cause in LostCause.values:
            _list_lost(mine, cause, now)
        bus.tell_people_on_commit(StandingChanged(user=user.pk))


def _list_lost(turns: QuerySet[Turn], cause: str, now: datetime) -> None:
    for turn in turns:
        if turn.lost_connections.count() < MOST_LOST:
            turn.lost_connections.create(at=now, cause=cause)


def note_waiting(user: Any, now: datetime) -> None:
    """Note that a person who waits is present, on any page.

    A running turn needs its robot's page; presence on other pages does not keep it.
    """
    if user.is_authenticated:
        Ticket.objects.filter(user=user, state__in=NOT_YET).update(last_seen=now)


def dismiss(ticket: int, user: Any, now: datetime) -> None:
    """Note that the person has read that this place was lost, or that this turn has ended."""
    mine = Ticket.objects.filter(pk=ticket, user=user, dismissed_at=None).exclude(state__in=OPEN_TICKET)
    if mine.update(dismissed_at=now):
        bus.tell_people_on_commit(StandingChanged(user=user.pk))
