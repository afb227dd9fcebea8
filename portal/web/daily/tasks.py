"""The periodic task that computes daily figures; it may be sent twice."""

from celery import shared_task

from portal.web.daily.figures import keep
from robots.kit.clock import SYSTEM


@shared_task(name="daily.figures", ignore_result=True, max_retries=0)
def daily_figures() -> int:
    """Compute the rows of today and of days before that are missing. Return for how many days."""
    return keep(SYSTEM.now())
