"""Reads the jobs and motions of 24 hours from the database: two indexes, and a limit for each."""

from dataclasses import dataclass
from datetime import datetime
from typing import Any

from django.db.models import F, Max, Sum

from portal.web.statistics.counting import CANCELLED, FAULT, GAVE_UP, OPEN, REACHED, REFUSED, UNKNOWN, Ask, Motion
from portal.web.statistics.day import Span
from queueing.models import Job, JobState
from queueing.services import FAULTS
from robots.kit.contract.capabilities import Statistics
from robots.models import Command, Robot, Usage
from robots.states import CommandState, GrantKind, Lane

MOST_JOBS, MOST_MOTIONS = 5000, 10_000
LOOK_BACK = 50  # motions before the 24 hours, of which the last reading is taken
AS_IT_IS = {
    JobState.WAITING: OPEN, JobState.RUNNING: OPEN, JobState.DONE: REACHED, JobState.CANCELLED: CANCELLED,
    JobState.UNKNOWN: UNKNOWN,
}  # fmt: skip


@dataclass(frozen=True)
class Use:
    """Time online (s), greatest number of viewers at once, and bytes sent to them; None: not known."""

    online_s: float | None = None
    watching: int | None = None
    sent_bytes: int | None = None


@dataclass(frozen=True)
class DayRecord:
    """Jobs and motions of 24 hours; `cut`: there were more than are read. `before`: earlier motions, newest first."""

    asks: list[Ask]
    motions: list[Motion]
    before: list[Motion]
    cut: bool
    use: Use


def use_of(robot: Robot, span: Span) -> Use:
    """Return the sums over the counts of five minutes that began in this span."""
    kept = Usage.objects.filter(robot=robot, at__gte=span.start, at__lt=span.end)
    found = kept.aggregate(online=Sum("online_s"), watching=Max("watching"), sent=Sum("sent_bytes"))
    return Use(found["online"], found["watching"], found["sent"])


def outcome_of(state: str, faults: int, command_state: str, code: str, own: frozenset[str]) -> str:
    """Return how a job ended: by its state, its faults, and the state and error code of its last command."""
    if state != JobState.FAILED:
        return AS_IT_IS[JobState(state)]
    if code in own:
        return code
    if code and command_state == CommandState.REJECTED:
        return REFUSED
    return FAULT if not code and faults >= FAULTS else GAVE_UP


def record_of(robot: Robot, declared: Statistics, span: Span, now: datetime) -> DayRecord:
    """Return the jobs that were asked for, and the motions that ended, in these 24 hours."""
    asks, cut = _asks(robot, declared, span)
    motions = Command.objects.filter(robot=robot, lane=Lane.MOTION, accepted_at__isnull=False)
    within = motions.filter(ended_at__gte=span.start, ended_at__lt=span.end).order_by("ended_at", "id")
    found = _motions(within[: MOST_MOTIONS + 1], now)
    over_the_end = motions.filter(ended_at__gte=span.end).order_by("ended_at", "id")[:1]
    if span.until < span.end:
        over_the_end = motions.filter(ended_at=None)[:1]
    last = [Motion(m.kind, m.state, m.began_at, m.ended_at) for m in _motions(over_the_end, now)]  # read the next day
    before = _motions(motions.filter(ended_at__lt=span.start).order_by("-ended_at", "-id")[:LOOK_BACK], now)
    return DayRecord(asks, found[:MOST_MOTIONS] + last, before, cut or len(found) > MOST_MOTIONS, use_of(robot, span))


def _motions(rows: Any, now: datetime) -> list[Motion]:
    found = rows.values_list("kind", "state", "accepted_at", "ended_at", "result__channels")
    return [
        Motion(kind, state, accepted, ended or now, _numbers(told, "began"), _numbers(told, "ended"))
        for kind, state, accepted, ended, told in found
    ]


def _numbers(told: Any, which: str) -> dict[str, float]:
    kept = told.get(which) if isinstance(told, dict) else None
    return kept if isinstance(kept, dict) else {}


def _asks(robot: Robot, declared: Statistics, span: Span) -> tuple[list[Ask], bool]:
    jobs = Job.objects.filter(robot=robot, asked_at__gte=span.start, asked_at__lt=span.end).order_by("asked_at", "id")
    rows = list(jobs.values_list("id", "asked_at", "state", "faults", "user_id", "guest", "code")[: MOST_JOBS + 1])
    last = _last_commands(robot, span)
    own = frozenset(code for code, _ in declared.ends)
    asks = []
    for pk, at, state, faults, user, guest, never in rows[:MOST_JOBS]:
        command_state, code, told = last.get(pk, ("", "", None))
        if never:  # the robot left it behind while it waited
            command_state, code = CommandState.REJECTED, never
        outcome = outcome_of(state, faults, command_state, code, own)
        asks.append(Ask(at, outcome, guest or f"{user}", _numbers(told, "began").get(declared.against)))
    return asks, len(rows) > MOST_JOBS


def _last_commands(robot: Robot, span: Span) -> dict[int, tuple[str, str, Any]]:
    """Return state, error code and channels of the last command of each job; jobs that never began have none."""
    runs = Command.objects.filter(
        grant__job_run__job__in=Job.objects.filter(robot=robot, asked_at__gte=span.start, asked_at__lt=span.end),
        grant__kind=GrantKind.JOB, lane=Lane.MOTION,
    )  # fmt: skip
    found = runs.annotate(job=F("grant__job_run__job")).order_by("-id")
    last: dict[int, tuple[str, str, Any]] = {}
    for job, state, code, told in found.values_list("job", "state", "result__code", "result__channels")[:MOST_MOTIONS]:
        last.setdefault(job, (state, code if isinstance(code, str) else "", told))
    return last
