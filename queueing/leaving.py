"""What ends with an account that is deleted: its turn, its places, its jobs, and what it may move as staff."""

from typing import Any

from django.conf import settings
from django.db import transaction
from django.db.models.signals import pre_delete
from django.dispatch import receiver

from queueing.jobs.asking import Asker
from queueing.jobs.cancelling import cancel
from queueing.models import OPEN_JOB, OPEN_TICKET, Job, PlaceEnd, Ticket
from queueing.tickets import remove
from robots.grants import end_grants_of
from robots.kit.clock import SYSTEM
from robots.models import Recording
from robots.recordings.keeping import forget_names
from robots.states import GrantEnd


@receiver(pre_delete, sender=settings.AUTH_USER_MODEL)
def leave_everything(instance: Any, **_: Any) -> None:
    """End what the person has open, so that no robot goes on moving for nobody."""
    now = SYSTEM.now()
    for ticket in Ticket.objects.filter(user=instance, state__in=OPEN_TICKET):
        remove(ticket, now, PlaceEnd.DELETED, GrantEnd.UNFIT)
    for job in Job.objects.filter(user=instance, state__in=OPEN_JOB):
        cancel(job, Asker(user=instance), now)
    end_grants_of(instance, PlaceEnd.DELETED, now)
    recordings = list(Recording.objects.filter(grant__holder=instance).values_list("pk", flat=True))
    transaction.on_commit(lambda: forget_names(recordings), robust=True)
