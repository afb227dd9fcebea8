"""What pages tell of jobs."""

from django import template

from queueing.jobs.suspending import waits_for_staff
from robots.models import Robot

register = template.Library()


@register.filter
def suspended(robot: Robot) -> bool:
    """Return whether jobs and the robot's own behaviour wait until staff resume them."""
    return waits_for_staff(robot)
