"""Deletes old jobs of guests."""

from datetime import datetime, timedelta

from django.db import transaction

from queueing.models import OPEN_JOB, Account, Job, Queue
from queueing.rows import lock
from robots.wall_clock import FIRST

KEPT = timedelta(days=400)
MOST = 1000  # jobs of a queue at a time, so that nobody waits long for its row


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
