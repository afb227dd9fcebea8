"""What the use of a robot costs: the account's finish tag and the queue's virtual time."""

from typing import Any

from queueing import fairshare
from queueing.models import OPEN_JOB, OPEN_TICKET, Account, Job, Queue, Ticket


def account_of(queue: Queue, user: Any) -> Account:
    """Return the person's account in the queue; the first call creates it."""
    return Account.objects.get_or_create(queue=queue, user=user)[0]


def account_of_guests(queue: Queue, network: str) -> Account:
    """Return the account that all guests of one network address share; staff may give it a weight of its own."""
    return Account.objects.get_or_create(queue=queue, user=None, network=network)[0]


def next_tag(queue: Queue, account: Account) -> float:
    """Return the start tag of the account's request that joins now."""
    return fairshare.start_tag(fairshare.Clock(queue.virtual_time, queue.greatest_finish), account.finish_tag)


def serve(queue: Queue, start_tag: float) -> None:
    """Advance the queue's virtual time to the request that is served now."""
    queue.virtual_time = fairshare.Clock(queue.virtual_time, queue.greatest_finish).serve(start_tag).virtual
    Queue.objects.filter(pk=queue.pk).update(virtual_time=queue.virtual_time)


def charge(queue: Queue, account: Account, start_tag: float, amount: float) -> None:
    """Charge a served request: seconds or jobs, divided by the weight of the account."""
    tag = fairshare.finish_tag(start_tag, amount, account.weighs(queue))
    Account.objects.filter(pk=account.pk).update(finish_tag=tag)
    queue.greatest_finish = fairshare.Clock(queue.virtual_time, queue.greatest_finish).finish(tag).greatest_finish
    Queue.objects.filter(pk=queue.pk).update(greatest_finish=queue.greatest_finish)


def settle(queue: Queue) -> None:
    """Remove credit for absence once nobody waits and nobody is served."""
    asked = Ticket.objects.filter(queue=queue, state__in=OPEN_TICKET).exists()
    if not asked and not Job.objects.filter(queue=queue, state__in=OPEN_JOB).exists():
        clock = fairshare.Clock(queue.virtual_time, queue.greatest_finish).empty()
        Queue.objects.filter(pk=queue.pk).update(virtual_time=clock.virtual)
        queue.virtual_time = clock.virtual
