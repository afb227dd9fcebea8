"""The next job of a robot."""

from django.db.models import Q

from queueing.models import Job, JobState
from robots.models import Robot


def head_of(robot: Robot) -> Job | None:
    """Return the robot's waiting job with the least start tag whose asker is still allowed to use the robot."""
    waiting = Job.objects.filter(robot=robot, state=JobState.WAITING, start_tag__isnull=False)
    there = waiting.filter(Q(user=None) | Q(user__is_active=True))
    return there.select_related("robot", "account", "user").order_by("start_tag", "id").first()
