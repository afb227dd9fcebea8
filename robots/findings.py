"""What commands have found on their way, for the pages of turns and jobs."""

from typing import Any

from django.db.models import QuerySet

from robots.models import Finding

SHOWN = 200  # findings, and pictures beside them


def findings_of(grants: Any) -> QuerySet[Finding]:
    """Return what was found under these grants (their numbers), in the order in which it was."""
    found = Finding.objects.filter(command__grant__in=grants).select_related("frame", "command__robot")
    return found.order_by("command_id", "number")[:SHOWN]
