"""Verbs of staff: the maintenance turn, and closing incidents."""

from datetime import timedelta
from typing import Any

from robots.grants import open_grant, start_grant
from robots.kit.clock import SYSTEM
from robots.kit.contract.errors import NotPermitted
from robots.models import Grant, Incident, Robot
from robots.services.commands import need_worker
from robots.services.permissions import need_staff
from robots.states import Cycle, GrantKind


def start_maintenance(robot: Robot, user: Any, minutes: int = 30) -> Grant:
    """Open a maintenance turn, in which staff drive under lock-out. Raises NotPermitted, RobotOffline."""
    need_staff(user)
    robot.refresh_from_db()
    if robot.cycle != Cycle.LOCKED_OUT:
        raise NotPermitted("Lock the robot out first; a maintenance turn runs under lock-out.")
    now = SYSTEM.now()
    need_worker(robot, now)
    grant = open_grant(robot)
    if grant is not None and grant.kind == GrantKind.STAFF and grant.holder_id == user.pk:
        return grant
    return start_grant(robot, GrantKind.STAFF, now, user, now + timedelta(minutes=minutes))


def close_incident(incident: Incident, user: Any) -> bool:
    """Mark an incident as dealt with. Return False if it was before."""
    need_staff(user)
    return bool(Incident.objects.filter(pk=incident.pk, closed_at=None).update(closed_at=SYSTEM.now()))
