"""The periodic tasks of the queues; each may be sent twice."""

from functools import cache

from celery import shared_task

from queueing.jobs.forgetting import forget_old_jobs
from queueing.steps import carry
from queueing.tick import tick_seldom
from robots import bus
from robots.bus import web_uptime
from robots.kit.clock import SYSTEM, Lock
from robots.wall_clock import wall_clock


@cache
def ticking() -> Lock:
    """Return the lock under which this process ticks."""
    return SYSTEM.lock()


@shared_task(name="queueing.tick", ignore_result=True, max_retries=0)
def queue_tick() -> None:
    """Advance every queue; first, if the time of day was set, move the stamps of open rows.

    One at a time: a tick that has begun would judge by the time of before what has followed the clock since.
    """
    if not ticking().acquire(blocking=False):
        return
    try:
        now = wall_clock().follow(carry)
        tick_seldom(now, web_uptime.up_since(now))
        bus.make_up()
    finally:
        ticking().release()


@shared_task(name="queueing.clean", ignore_result=True, max_retries=0)
def clean() -> int:
    """Delete old jobs of guests. Return how many."""
    return forget_old_jobs(wall_clock().age_now)
