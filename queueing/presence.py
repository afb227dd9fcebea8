"""Notes that people are present, and that they have read the end of their place."""

from datetime import datetime
from typing import Any

from queueing.models import NOT_YET, OPEN_TICKET, Ticket, TicketState, Turn, TurnSession
from queueing.tickets import open_ticket
from robots import bus
from robots.kit.packets import StandingChanged
from robots.models import Robot


def note_presence(robot: Robot, user: Any, now: datetime, classic: bool | None = None, session: str = "") -> None:
    """Count a heartbeat or a request as presence; `session`: the key of the session in which a page reports.

    `now`: when it came. A page's sockets are noted in threads of their own, so a later absence may have been noted
    before; it stays.
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


def note_disconnection(robot: Robot, user: Any, now: datetime, session: str = "") -> None:
    """Note that the operator's socket closed; the turn is kept for a while. `session`: its session's key."""
    mine = Turn.objects.filter(robot=robot, user=user, ended_at=None, classic=False)
    TurnSession.objects.filter(turn__in=mine, session=session).delete()
    if mine.update(connected=False, last_seen=now):
        bus.tell_people_on_commit(StandingChanged(user=user.pk))


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
