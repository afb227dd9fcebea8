"""The periodic tasks of the queues; each may be sent twice."""

from datetime import datetime, timedelta
from functools import cache

from celery import shared_task
from django.db import transaction

from accounts.services import remove_guests
from queueing.models import OPEN_JOB, Account, Job, Queue
from queueing.rows import lock
from queueing.steps import carry
from queueing.tick import tick_seldom
from robots import bus
from robots.bus import web_uptime
from robots.kit.clock import SYSTEM, Lock, unless_busy
from robots.wall_clock import FIRST, wall_clock

KEPT = timedelta(days=400)
MOST = 1000  # jobs of a queue at a time, so that nobody waits long for its row


@cache
def ticking() -> Lock:
    """Return the lock under which this process ticks."""
    return SYSTEM.lock()


@shared_task(name="queueing.tick", ignore_result=True, max_retries=0)
def queue_tick() -> None:
    """Advance every queue; first, if the time of day was set, move the stamps of open rows.

    Only one tick runs at a time: another would judge stamps that were moved meanwhile by the time before the step.
    """
    unless_busy(ticking(), _tick)


def _tick() -> None:
    now = wall_clock().follow(carry)
    tick_seldom(now, web_uptime.up_since(now))
    bus.make_up()


@shared_task(name="queueing.clean", ignore_result=True, max_retries=0)
def clean() -> int:
    """Delete old jobs of guests, and guests of yesterday. Return how many rows."""
    now = wall_clock().age_now
    return forget_old_jobs(now) + remove_guests(now)


def forget_old_jobs(now: datetime) -> int:
    """Delete guests' jobs that ended more than 400 days ago, and guests' accounts without a job. Return how many jobs.

    Jobs of people stay with their account.
    """
    return sum(_forget(queue, now) for queue in Queue.objects.all())


def _forget(queue: Queue, now: datetime) -> int:
    with transaction.atomic():
        lock(queue)  # a request that comes now finds the account, or makes one, after this
        old = Job.objects.filter(queue=queue, user=None, ended_at__gte=FIRST, ended_at__lt=now - KEPT)
        old = old.exclude(state__in=OPEN_JOB)
        numbers = list(old.order_by("id").values_list("pk", flat=True)[:MOST])
        if numbers:
            Job.objects.filter(pk__in=numbers).delete()
        Account.objects.filter(queue=queue, user=None, jobs=None).delete()
        return len(numbers)
