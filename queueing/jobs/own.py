"""Acts of people and guests on their own jobs: cancel one, see its end, answer the survey. Staff cancel any job."""

from datetime import datetime, timedelta

from django.db import transaction
from django.db.models import BigAutoField, CharField, DateTimeField, QuerySet

from queueing.errors import NotYourJob
from queueing.jobs.asking import Asker
from queueing.jobs.running import end
from queueing.models import OPEN_JOB, Job, JobState
from queueing.rows import lock
from robots.grants import end_grant
from robots.people import is_person
from robots.prepared import Prepared, Slot
from robots.states import GrantEnd

LATELY = timedelta(days=1)  # pages mention a job that has ended for this time
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


def may_cancel(job: Job, asker: Asker) -> bool:
    """Return whether the person or guest asked for the job, or is staff."""
    if asker.user is not None:
        return bool(is_person(asker.user, job.user_id) or asker.user.has_perm("robots.change_robot"))
    return bool(job.guest) and job.guest == asker.guest


def cancel(job: Job, asker: Asker, now: datetime) -> bool:
    """Cancel a job. A waiting job ends at once; the grant of a running job ends, so the robot holds its position.

    Return False if the job had ended. Raises NotYourJob: neither its asker nor staff.
    """
    if not may_cancel(job, asker):
        raise NotYourJob("Only the person who asked for this job, and staff, can cancel it.")
    with transaction.atomic():
        queue = lock(job.queue)
        job.refresh_from_db()
        was_open = job.state in OPEN_JOB
        if job.state == JobState.WAITING:
            end(queue, job, JobState.CANCELLED, "Cancelled.", 0.0, now)
        elif job.state == JobState.RUNNING:
            Job.objects.filter(pk=job.pk).update(cancel_asked_at=now)
            if (run := job.last_run()) is not None:
                end_grant(run.grant, GrantEnd.HOLDER, "cancelled by its asker", now)
        return was_open
