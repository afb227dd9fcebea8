"""Gives one request of each account a start tag, a ticket or a job; further requests wait without a tag."""

from queueing.charging import next_tag
from queueing.models import OPEN_JOB, OPEN_TICKET, Account, Job, JobState, Queue, Ticket
from queueing.rows import QUEUE
from robots.prepared import Prepared

_UNTAGGED: Prepared[Job] = Prepared(
    lambda: (
        Job.objects.filter(queue=QUEUE, state=JobState.WAITING, start_tag=None).select_related("account").order_by("id")
    )
)


def tag_next(queue: Queue) -> None:
    """Tag the first waiting job of each account without a tag in the queue. Can be repeated."""
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
