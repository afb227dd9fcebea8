"""Incidents: faults of a robot, kept for staff."""

from datetime import datetime
from typing import Any

from robots.kit.clock import SYSTEM
from robots.models import Command, Incident, Robot
from robots.services.permissions import need_staff

# the remedies of incidents that end without anybody's help
TRIED_AGAIN = "Trying again every few seconds."
NOT_OFFERED = "Not offered."


def incident(
    robot: Robot, code: str, text: str, now: datetime, command: Command | None = None, remedy: str = ""
) -> Incident:
    """Store a fault, and the remedy that was applied. Return the row."""
    return Incident.objects.create(
        robot=robot, command=command, at=now, code=code, text=text[:300], remedy=remedy[:300]
    )


def close_incident(incident: Incident, user: Any) -> bool:
    """Mark an incident as dealt with. Return False if it was marked before."""
    need_staff(user)
    return bool(Incident.objects.filter(pk=incident.pk, closed_at=None).update(closed_at=SYSTEM.now()))
