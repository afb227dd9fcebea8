"""Turns and waits on pages."""

from collections.abc import Mapping
from typing import Any

from django import template

from queueing.models import Turn
from queueing.services import End, end_of_turn, wait_said

register = template.Library()
register.filter("wait_said", wait_said)


@register.filter
def turn_end(turn: Turn) -> End | None:
    """Return why a turn ended, what it costs and what is next; None while it goes on."""
    return end_of_turn(turn) if turn.ended_at is not None else None


@register.filter
def at_key(table: Mapping[int, Any], key: int) -> Any:
    """Return what a table has under a key; None where it has nothing."""
    return table.get(key)
