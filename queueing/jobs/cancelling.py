"""Cancels jobs, for their asker and for staff. The robot holds; nothing is latched."""

from datetime import datetime

from django.db import transaction

from queueing.errors import NotYourJob
from queueing.jobs.asking import Asker
from queueing.jobs.running import end
from queueing.models import OPEN_JOB, Job, JobState
from queueing.rows import lock
from robots.grants import end_grant
from robots.people import is_person
from robots.states import GrantEnd


def may_cancel(job: Job, asker: Asker) -> bool:
    """Return whether the person or guest asked for the job, or is staff."""
    if asker.user is not None:
        return bool(is_person(asker.user, job.user_id) or asker.user.has_perm("robots.change_robot"))
    return bool(job.guest) and job.guest == asker.guest


def cancel(job: Job, asker: Asker, now: datetime) -> bool:
    """Cancel a job. A waiting job ends at once; the grant of a running job ends, so the robot holds.

    Return False if it had ended.

    Raises:
        NotYourJob: neither its asker nor staff.
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
            run = job.runs.select_related("grant__robot").order_by("-id").first()
            if run is not None:
                end_grant(run.grant, GrantEnd.HOLDER, "cancelled by its asker", now)
        return was_open
