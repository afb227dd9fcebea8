"""Tests of robots that no worker owns: requested by staff, carried out one after another.

The request is in the robot's row; the message is only a wake-up. After a lost message, the next request or the next
start of the housekeeping worker carries out the test; a second message finds nothing to do.
"""

from datetime import datetime, timedelta
from typing import Any

from django.db.models import Q

from robots import bus
from robots.kit.contract.errors import NotPermitted
from robots.kit.packets import Changed
from robots.models import Robot
from robots.services import RobotOffline
from robots.services.permissions import need_staff

LIMIT_S = 120.0  # a test that takes longer died with its process


def ask(robot: Robot, user: Any, now: datetime) -> None:
    """Request a test of the robot's connection and camera.

    Raises:
        NotStaff: the person is not staff.
        NotPermitted: a test of this robot is requested already.
        RobotOffline: the housekeeping worker cannot be reached now.
    """
    need_staff(user)
    free = Q(probe_asked_at=None) | Q(probe_begun_at__lte=now - timedelta(seconds=LIMIT_S))
    new = Robot.objects.filter(free, pk=robot.pk).update(probe_asked_at=now, probe_begun_at=None)
    if not bus.wake_probes():
        Robot.objects.filter(pk=robot.pk, probe_begun_at=None).update(probe_asked_at=None)
        raise RobotOffline("The test needs the live link (Redis), which is down.")
    if not new:
        raise NotPermitted("A test of this robot is running; wait for its answer below.")


def claim(now: datetime) -> Robot | None:
    """Claim the next requested test and return its robot; None if no test waits."""
    waiting = Robot.objects.filter(probe_begun_at=None).exclude(probe_asked_at=None)
    for robot in waiting.order_by("probe_asked_at", "pk"):
        if waiting.filter(pk=robot.pk).update(probe_begun_at=now):
            return robot
    return None


def waiting() -> bool:
    """Return whether a test waits."""
    return Robot.objects.filter(probe_begun_at=None).exclude(probe_asked_at=None).exists()


def is_lost(robot: Robot, now: datetime) -> bool:
    """Return whether the robot's test died with its process, so that another may be requested."""
    return robot.probe_begun_at is not None and robot.probe_begun_at <= now - timedelta(seconds=LIMIT_S)


def finish(robot: Robot, result: dict[str, Any], now: datetime) -> None:
    """Store the result of a test."""
    result = {**result, "at": now.isoformat()}
    Robot.objects.filter(pk=robot.pk).update(probe=result, probe_asked_at=None, probe_begun_at=None)
    bus.publish(robot.slug, Changed("robot"))
