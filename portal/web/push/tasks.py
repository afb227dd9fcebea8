"""The periodic tasks that tell people of their turn; each may be sent twice, and run in two processes."""

from functools import cache

from celery import shared_task

from portal.web.push.mailing import mail_offers
from portal.web.push.sending import tell_offers
from robots.kit.clock import SYSTEM, Lock, unless_busy


@cache
def telling() -> Lock:
    """Return the lock under which this process tells: a slow push service keeps one thread of the worker, not all."""
    return SYSTEM.lock()


@cache
def mailing() -> Lock:
    """Return the lock under which this process mails: a slow mail server keeps one thread of the worker, not all."""
    return SYSTEM.lock()


@shared_task(name="push.tell", ignore_result=True, max_retries=0)
def tell() -> None:
    """Tell people of their offers."""
    unless_busy(telling(), lambda: tell_offers(SYSTEM.now()))


@shared_task(name="push.mail", ignore_result=True, max_retries=0)
def mail() -> None:
    """Tell people of their offers by e-mail."""
    unless_busy(mailing(), lambda: mail_offers(SYSTEM))
