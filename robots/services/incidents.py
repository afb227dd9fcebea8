"""Incidents: faults of a robot, kept for staff."""

from datetime import datetime

from robots.models import Command, Incident, Robot


def incident(
    robot: Robot, code: str, text: str, now: datetime, command: Command | None = None, remedy: str = ""
) -> Incident:
    """Store what went wrong and what was done about it."""
    return Incident.objects.create(
        robot=robot, command=command, at=now, code=code, text=text[:300], remedy=remedy[:300]
    )
