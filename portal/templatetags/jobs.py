"""Jobs on pages."""

from django import template

from queueing.models import Job
from queueing.services import label_of, waits_for_staff
from robots.kit.contract.ranges import plain
from robots.models import Robot
from robots.sentences import in_digits as digits

register = template.Library()
register.filter("bound", plain)


@register.filter
def in_digits(value: object) -> object:
    """Return a number as people read it; anything else as it is."""
    return digits(value) if isinstance(value, int | float) and not isinstance(value, bool) else value


@register.filter
def suspended(robot: Robot) -> bool:
    """Return whether jobs and the robot's own behaviour wait until staff resume them."""
    return waits_for_staff(robot)


@register.filter
def job_label(job: Job) -> str:
    """Return what the robot calls this kind of job."""
    return label_of(job.robot, job.kind)
