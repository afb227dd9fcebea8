"""A stop suspends jobs, idle behaviour and needs; staff resume them after looking."""

from datetime import datetime
from typing import Any

from queueing.models import QueueRobot
from queueing.rows import announce, queue_of
from robots.drivers.errors import NotPermitted
from robots.models import Robot
from robots.permissions import need_staff


def suspended(robot: Robot, link: QueueRobot | None) -> bool:
    """Tell whether nothing may begin by itself: a stop is latched, or nobody has looked since the last."""
    if robot.stop_latched:
        return True
    resumed = link.resumed_at if link is not None else None
    return robot.stopped_at is not None and (resumed is None or resumed < robot.stopped_at)


def resume(robot: Robot, user: Any, now: datetime) -> None:
    """Let jobs, idle behaviour and needs go on after a stop.

    Raises:
        NotStaff: only staff resume.
        NotPermitted: the stop is not released.

    """
    need_staff(user)
    robot.refresh_from_db()
    if robot.stop_latched:
        raise NotPermitted("Release the stop first; then resume the jobs.")
    queue = queue_of(robot)
    QueueRobot.objects.filter(robot=robot).update(resumed_at=now)
    announce(queue)
