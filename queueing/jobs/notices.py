"""Notices on every page that a job has ended, until its asker has looked at it or dismissed it."""

from datetime import datetime, timedelta

from django.db.models import BigAutoField, CharField, DateTimeField, QuerySet

from queueing.jobs.asking import Asker
from queueing.models import OPEN_JOB, Job
from robots.prepared import Prepared, Slot

LATELY = timedelta(days=1)  # for so long pages mention a job that has ended
_OF_PERSON: Prepared[Job] = Prepared(lambda: _unseen(Job.objects.filter(user=Slot("user", BigAutoField()))))
_OF_GUEST: Prepared[Job] = Prepared(lambda: _unseen(Job.objects.filter(guest=Slot("guest", CharField()))))


def _unseen(jobs: QuerySet[Job]) -> QuerySet[Job]:
    lately = jobs.exclude(state__in=OPEN_JOB).filter(told_at=None, ended_at__gt=Slot("since", DateTimeField()))
    return lately.select_related("robot").order_by("-id")[:3]


def own_jobs(asker: Asker) -> QuerySet[Job]:
    """Return the jobs of a person, or of a guest; none of somebody without a cookie."""
    if asker.user is not None:
        return Job.objects.filter(user=asker.user)
    return Job.objects.filter(guest=asker.guest) if asker.guest else Job.objects.none()


def unseen_jobs(asker: Asker, now: datetime) -> list[Job]:
    """Return the asker's jobs that ended within a day and that they have neither looked at nor dismissed."""
    if asker.user is not None:
        return _OF_PERSON(user=asker.user.pk, since=now - LATELY)
    return _OF_GUEST(guest=asker.guest, since=now - LATELY) if asker.guest else []


def mark_seen(job: Job, asker: Asker, now: datetime) -> None:
    """Note that the asker has seen the end of the job, on its page or elsewhere."""
    if job.state not in OPEN_JOB:
        own_jobs(asker).filter(pk=job.pk, told_at=None).update(told_at=now)


def may_answer(job: Job, asker: Asker) -> bool:
    """Return whether the survey is open to this asker: the job is theirs, has ended, and was not answered for."""
    return _unanswered(job, asker).exists()


def note_answered(job: Job, asker: Asker) -> bool:
    """Note that the asker of an ended job has answered the survey. Return False if they may not, or did before."""
    return bool(_unanswered(job, asker).update(surveyed=True))


def _unanswered(job: Job, asker: Asker) -> QuerySet[Job]:
    return own_jobs(asker).filter(pk=job.pk, surveyed=False).exclude(state__in=OPEN_JOB)
