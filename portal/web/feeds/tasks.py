"""The periodic task of the status feeds; it may be sent twice, and run in two processes."""

from celery import shared_task

from portal.web.feeds.following import follow
from robots.kit.clock import SYSTEM


@shared_task(name="feeds.downtimes", ignore_result=True, max_retries=0)
def downtimes() -> None:
    """Note which robots are out of service, and which are back."""
    follow(SYSTEM.now())
