"""The findings of commands, for the pages of turns and jobs."""

from collections.abc import Iterable
from typing import Any

from django.db.models import QuerySet

from robots.models import Command, Finding

SHOWN = 200  # on a page, unless the visitor asks for all
MOST = 5000  # of one page or movie


def findings_of(grants: Any) -> QuerySet[Finding]:
    """Return the findings under these grants (primary keys), in the order of their commands."""
    found = Finding.objects.filter(command__grant__in=grants).select_related("frame", "command__robot")
    return found.order_by("command_id", "number")[:MOST]


def left_out(commands: Iterable[Command]) -> int:
    """Return how many findings of these commands were not stored, because there were too many."""
    numbers = (command.result.get("left_out") for command in commands)
    return sum(number for number in numbers if isinstance(number, int))
