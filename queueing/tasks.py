"""The periodic task of the queues; it may be sent twice."""

from celery import shared_task

from queueing.tick import tick_seldom
from robots.clock import SYSTEM


@shared_task(name="queueing.tick", ignore_result=True, max_retries=0)
def queue_tick() -> None:
    """Advance every queue."""
    tick_seldom(SYSTEM.now())
