"""That a person is there, on whatever page, and has been told what became of their place."""

from datetime import datetime
from typing import Any

from queueing.models import NOT_YET, Ticket, TicketState
from robots import bus
from robots.messages import StandingChanged


def present(user: Any, now: datetime) -> None:
    """Count a sign of life from any page for all places in which the person waits.

    A turn that runs needs the page of its robot: it is not lengthened from elsewhere.
    """
    if user.is_authenticated:
        Ticket.objects.filter(user=user, state__in=NOT_YET).update(last_seen=now)


def dismiss(ticket: int, user: Any, now: datetime) -> None:
    """Remember that the person has read that this place of theirs was given on."""
    mine = Ticket.objects.filter(pk=ticket, user=user, state=TicketState.EXPIRED, dismissed_at=None)
    if mine.update(dismissed_at=now):
        bus.tell_people_on_commit(StandingChanged(user=user.pk))
