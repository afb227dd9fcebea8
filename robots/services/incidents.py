"""Incidents: faults of a robot, kept for staff."""

from datetime import datetime
from typing import Any

from robots.kit.clock import SYSTEM
from robots.models import Command, Incident, Robot
from robots.services.permissions import need_staff

# the remedies of incidents that end without anybody's help
TRIED_AGAIN = "Trying again every few seconds."
NOT_OFFERED = "Not offered."
TRANSIENT = (TRIED_AGAIN, NOT_OFFERED)  # closed when the robot is ready again
AS_IT_IS = "The robot is offered as it is. Put right what was left, or tidy up from the robot's page of the admin."
BACK_IN_PLACE = "Tidied up later."
UNTIDY = "untidy"


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


def note_untidy(robot: Robot, text: str, now: datetime) -> None:
    """Store what could not be tidied up between two turns, unless an earlier incident says so and is open."""
    if not Incident.objects.filter(robot=robot, code=UNTIDY, closed_at=None).exists():
        incident(robot, UNTIDY, text, now, remedy=AS_IT_IS)


def note_tidy(robot: Robot, now: datetime) -> None:
    """Close what an earlier handover has left, now that everything is in its place."""
    Incident.objects.filter(robot=robot, code=UNTIDY, closed_at=None).update(closed_at=now, remedy=BACK_IN_PLACE)
