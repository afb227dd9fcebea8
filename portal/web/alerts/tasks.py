"""The periodic task of alerts; it may be sent twice, and run in two processes."""

from celery import shared_task

from portal.web.alerts.following import follow
from portal.web.alerts.sending import send_due
from robots.kit.clock import SYSTEM


@shared_task(name="alerts.tell", ignore_result=True, max_retries=0)
def tell() -> None:
    """Find out who needs staff, and send what is due."""
    follow(SYSTEM.now())
    send_due(SYSTEM.now())
