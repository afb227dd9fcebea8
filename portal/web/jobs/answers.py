"""Jobs as JSON, for a robot's console: ask for one, list one's own, cancel one."""

from datetime import datetime, timedelta
from typing import Any

from django.db.models import Q
from django.http import HttpRequest, JsonResponse

from queueing.errors import NotCleared, NotYourJob, QueueError, TooManyJobs, TooOften
from queueing.models import OPEN_JOB, Job, JobState
from queueing.services import Asker, own_jobs
from robots.kit.contract.errors import NotPermitted
from robots.models import Robot
from robots.sentences import english
from robots.services.permissions import NotStaff

LISTED = 10
RECENT = timedelta(hours=1)  # for so long one's own ended jobs are listed
STATUS: dict[type[Exception], int] = {
    NotCleared: 403, NotYourJob: 403, NotStaff: 403, NotPermitted: 409, TooManyJobs: 429, TooOften: 429,
}  # fmt: skip
AGAIN_S = "300"  # the longest wait until one may ask again


def wants_json(request: HttpRequest) -> bool:
    """Return whether a script asks, and not a person in a browser."""
    return request.get_preferred_type(["text/html", "application/json"]) == "application/json"


def job_fields(job: Job) -> dict[str, Any]:
    """Return the fields of a job for its asker."""
    return {
        "id": job.pk, "kind": job.kind, "args": job.args, "state": job.state,
        "label": english(JobState(job.state).label), "reason": job.reason, "open": job.state in OPEN_JOB,
        "url": job.get_absolute_url(), "asked_ms": int(job.asked_at.timestamp() * 1000),
    }  # fmt: skip


def own_jobs_answer(robot: Robot, asker: Asker, now: datetime) -> JsonResponse:
    """List the asker's jobs on the robot: the open ones and those that ended within the last hour, newest first."""
    found = own_jobs(asker).filter(Q(ended_at=None) | Q(ended_at__gt=now - RECENT), robot=robot)
    return JsonResponse({"jobs": [job_fields(job) for job in found.order_by("-id")[:LISTED]]})


def status_of(error: Exception) -> int:
    """Return the status code of an answer that refuses."""
    return STATUS.get(type(error), 409 if isinstance(error, QueueError) else 400)


def refusal(error: Exception) -> JsonResponse:
    """Answer with the one sentence that says why not."""
    answer = JsonResponse({"error": str(error)}, status=status_of(error))
    if isinstance(error, TooOften):
        answer["Retry-After"] = AGAIN_S
    return answer
