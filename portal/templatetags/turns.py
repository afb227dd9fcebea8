"""What pages tell of turns and of waiting."""

from django import template

from queueing import words
from queueing.end_words import End
from queueing.endings import end_of_turn
from queueing.models import Turn

register = template.Library()
register.filter("wait_said", words.wait_said)


@register.filter
def turn_end(turn: Turn) -> End | None:
    """Return why a turn ended, what it costs and what is next; None while it goes on."""
    return end_of_turn(turn) if turn.ended_at is not None else None
