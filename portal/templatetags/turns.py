"""Turns and waits on pages."""

from django import template

from queueing.models import Turn
from queueing.services import End, end_of_turn, wait_said

register = template.Library()
register.filter("wait_said", wait_said)


@register.filter
def turn_end(turn: Turn) -> End | None:
    """Return why a turn ended, what it costs and what is next; None while it goes on."""
    return end_of_turn(turn) if turn.ended_at is not None else None
