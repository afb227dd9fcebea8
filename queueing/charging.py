"""Start tags, charges and the queue's virtual time.

Each account has a start tag for one request at a time, a ticket or a job; its other requests wait without a tag.
"""

from typing import Any

from queueing import fairshare
from queueing.models import OPEN_JOB, OPEN_TICKET, Account, Job, JobState, Queue, Ticket
from queueing.rows import QUEUE
from robots.prepared import Prepared

_UNTAGGED: Prepared[Job] = Prepared(
    lambda: (
        Job.objects.filter(queue=QUEUE, state=JobState.WAITING, start_tag=None).select_related("account").order_by("id")
    )
)


def account_of(queue: Queue, user: Any) -> Account:
    """Return the person's account in the queue; the first call creates it."""
    return Account.objects.get_or_create(queue=queue, user=user)[0]


def account_of_guests(queue: Queue, network: str) -> Account:
    """Return the account that all guests of one network address share; the first call creates it."""
    return Account.objects.get_or_create(queue=queue, user=None, network=network)[0]


def next_tag(queue: Queue, account: Account) -> float:
    """Return the start tag of the account's request that joins now."""
    return fairshare.start_tag(_clock(queue), account.finish_tag)


def _clock(queue: Queue) -> fairshare.Clock:
    return fairshare.Clock(queue.virtual_time, queue.greatest_finish)


def serve(queue: Queue, start_tag: float) -> None:
    """Advance the queue's virtual time to the request that is served now."""
    queue.virtual_time = _clock(queue).serve(start_tag).virtual
    Queue.objects.filter(pk=queue.pk).update(virtual_time=queue.virtual_time)


def charge(queue: Queue, account: Account, start_tag: float, amount: float) -> None:
    """Charge a served request: seconds or jobs, divided by the weight of the account."""
    tag = fairshare.finish_tag(start_tag, amount, account.weighs(queue))
    Account.objects.filter(pk=account.pk).update(finish_tag=tag)
    queue.greatest_finish = _clock(queue).finish(tag).greatest_finish
    Queue.objects.filter(pk=queue.pk).update(greatest_finish=queue.greatest_finish)


def settle(queue: Queue) -> None:
    """Remove credit for absence once nobody waits and nobody is served."""
    asked = Ticket.objects.filter(queue=queue, state__in=OPEN_TICKET).exists()
    if not asked and not Job.objects.filter(queue=queue, state__in=OPEN_JOB).exists():
        queue.virtual_time = _clock(queue).empty().virtual
        Queue.objects.filter(pk=queue.pk).update(virtual_time=queue.virtual_time)


def tag_next(queue: Queue) -> None:
    """Give a start tag to the first waiting job of each account that has none in the queue. Safe to repeat."""
    seen: set[int] = set()
    for job in _UNTAGGED(queue=queue.pk):
        if job.account_id in seen or _has_tagged(job.account):
            continue
        seen.add(job.account_id)
        Job.objects.filter(pk=job.pk, start_tag=None).update(start_tag=next_tag(queue, job.account))


def _has_tagged(account: Account) -> bool:
    if Job.objects.filter(account=account, state__in=OPEN_JOB, start_tag__isnull=False).exists():
        return True
    if account.user_id is None:
        return False
    return Ticket.objects.filter(queue=account.queue_id, user=account.user_id, state__in=OPEN_TICKET).exists()


def give_way(account: Account) -> None:
    """Remove the tag of the account's waiting job, because the person takes a ticket now."""
    Job.objects.filter(account=account, state=JobState.WAITING).update(start_tag=None)


def follow_charge(account: Account) -> None:
    """Move a ticket that was taken while a job of the person ran, by the cost of that job."""
    if account.user_id is not None:
        mine = Ticket.objects.filter(queue=account.queue_id, user=account.user_id, state__in=OPEN_TICKET)
        mine.filter(start_tag__lt=account.finish_tag).update(start_tag=account.finish_tag)
