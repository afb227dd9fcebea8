"""The next job of a robot."""

from queueing.jobs.judging import unfit
from queueing.jobs.kinds import job_kinds
from queueing.models import Job, JobState, QueueRobot
from robots.models import Robot


def head_of(robot: Robot, link: QueueRobot) -> Job | None:
    """Return the robot's waiting job with the least start tag whose asker may still ask for it.

    None while the robot's package is not installed, which alone knows how a job is begun.
    """
    waiting = Job.objects.filter(robot=robot, state=JobState.WAITING, start_tag__isnull=False)
    if not waiting.exists() or not job_kinds(robot):
        return None
    there = waiting.exclude(unfit(robot, link.guests_ask))
    return there.select_related("robot", "account", "user").order_by("start_tag", "id").first()
