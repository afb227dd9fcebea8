"""The periodic tasks of the queues; each may be sent twice."""

from celery import shared_task

from queueing.jobs.forgetting import forget_old_jobs
from queueing.steps import carry
from queueing.tick import tick_seldom
from robots import bus
from robots.clock import SYSTEM
from robots.wall_clock import wall_clock


@shared_task(name="queueing.tick", ignore_result=True, max_retries=0)
def queue_tick() -> None:
    """Advance every queue; first, if the time of day was set, what is open follows it."""
    wall_clock().follow(carry)
    tick_seldom(SYSTEM.now())
    bus.make_up()


@shared_task(name="queueing.clean", ignore_result=True, max_retries=0)
def clean() -> int:
    """Delete old jobs of guests. Return how many."""
    return forget_old_jobs(wall_clock().age_now)
