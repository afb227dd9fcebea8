"""Verbs of staff on a queue: remove a person, end a turn. Each checks the permission itself."""

from datetime import datetime
from typing import Any

from queueing import tickets, turns
from queueing.models import Ticket, Turn
from robots.services.permissions import need_staff
from robots.states import GrantEnd


def remove(ticket: Ticket, user: Any, now: datetime) -> bool:
    """Remove a person from the queue; a running turn is ended. Return False if the place had ended. Raises NotStaff."""
    need_staff(user)
    return tickets.remove(ticket, now)


def end(turn: Turn, user: Any, now: datetime) -> bool:
    """End a running turn. Return False if it had ended. Raises NotStaff."""
    need_staff(user)
    return turns.end_turn(turn, GrantEnd.STAFF, "ended by staff", now)
