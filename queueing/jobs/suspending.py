"""A stop suspends jobs, idle behaviour and needs; staff resume them after a look at the robot."""

from datetime import datetime
from typing import Any

from queueing.jobs.kinds import job_kinds
from queueing.models import QueueRobot
from queueing.rows import announce, is_suspended, link_of, queue_of
from robots.kit.contract.capabilities import Idle, Need
from robots.kit.contract.errors import NotPermitted
from robots.kit.contract.find import spec_or_none
from robots.models import Robot
from robots.services.permissions import need_staff

RESUMED = "Jobs and the robot's own behaviour go on."


def waits_for_staff(robot: Robot) -> bool:
    """Return whether a robot that takes jobs, or moves by itself, waits until staff resume it after a stop."""
    if not robot.stop_latched and robot.stopped_at is None:  # the usual case, without a query
        return False
    return _works_alone(robot) and is_suspended(robot, link_of(robot))


def _works_alone(robot: Robot) -> bool:
    spec = spec_or_none(robot.driver)
    return spec is not None and bool(job_kinds(robot) or spec.all_of(Idle) or spec.all_of(Need))


def resume(robot: Robot, user: Any, now: datetime) -> None:
    """Let jobs, idle behaviour and needs go on after a stop.

    Raises:
        NotStaff: the person is not staff.
        NotPermitted: the stop is not released.
    """
    need_staff(user)
    robot.refresh_from_db()
    if robot.stop_latched:
        raise NotPermitted("Release the stop first; then resume the jobs.")
    queue = queue_of(robot)
    QueueRobot.objects.filter(robot=robot).update(resumed_at=now)
    announce(queue)
