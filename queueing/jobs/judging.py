"""Judges whether waiting jobs may still start, and finds the next one.

A waiting job is judged by the rule for requests (`kinds.may_ask`) and by the robot's present state.
"""

from datetime import datetime, timedelta
from functools import reduce
from operator import or_

from django.db.models import Q, QuerySet

from accounts.services import cleared_people
from queueing.jobs.forecasts import any_waits
from queueing.jobs.kinds import job_kinds, job_kinds_or_none
from queueing.jobs.running import end
from queueing.models import Job, JobState, Queue, QueueRobot
from queueing.rows import links_of
from robots.grants import lease_of
from robots.kit.contract.capabilities import GoodWhile
from robots.kit.contract.find import spec_or_none
from robots.kit.contract.spec import CommandKind
from robots.models import Robot
from robots.models.robot import FRESH

SWITCHED_OFF = "The account of the person who asked for it is switched off."
NO_SUCH_KIND = "This robot no longer takes this kind of job."
NO_GUESTS = "This robot no longer takes jobs from guests."
NOT_CLEARED = "The person who asked for it is no longer cleared for this robot."
NO_JOB = Q(pk=None)
LATER = timedelta(seconds=2)  # a state must be newer than the job by this: clocks of hosts differ


def judge_waiting(queue: Queue, now: datetime) -> None:
    """End the waiting jobs that may not start any more, each with the reason; they cost nothing."""
    if not any_waits(queue.pk):
        return
    waiting = Job.objects.filter(queue=queue, state=JobState.WAITING).select_related("account", "robot", "user")
    for link in links_of(queue):
        of_robot = waiting.filter(robot=link.robot)
        rules = refusals(link.robot, link.guests_ask)
        for job in list(of_robot.filter(_any(rules))):
            why = next(reason for rule, reason in rules if Job.objects.filter(rule, pk=job.pk).exists())
            end(queue, job, JobState.CANCELLED, why, 0.0, now)
        for job, good in outdated_jobs(link.robot, of_robot, now):
            end(queue, job, JobState.FAILED, good.text, 0.0, now, good.code)


def refusals(robot: Robot, guests_ask: bool) -> tuple[tuple[Q, str], ...]:
    """Return filters of jobs that nobody may ask for any more, each with the reason as a sentence.

    Kinds and clearances are not checked while the robot's package is not installed.
    """
    kinds = job_kinds_or_none(robot)
    found = [(Q(user__is_active=False), SWITCHED_OFF)]
    if kinds is not None:
        found.append((~Q(kind__in=[kind.kind for kind in kinds]), NO_SUCH_KIND))
    if not guests_ask:
        found.append((Q(user=None), NO_GUESTS))
        if robot.clearance_required:
            found += [(_not_cleared(robot, kind), NOT_CLEARED) for kind in kinds or ()]
    return tuple(found)


def _not_cleared(robot: Robot, kind: CommandKind) -> Q:
    return Q(kind=kind.kind, user__isnull=False) & ~Q(user__in=cleared_people(robot, kind.level))


def _any(rules: tuple[tuple[Q, str], ...]) -> Q:
    return reduce(or_, (rule for rule, _ in rules), NO_JOB)


def outdated_jobs(robot: Robot, waiting: QuerySet[Job], now: datetime) -> list[tuple[Job, GoodWhile]]:
    """Return the robot's waiting jobs with an argument that its state no longer matches, each with the spec's rule.

    A state that is old, or was reported before the job was asked for, is not used: the asker may have seen a newer one.
    """
    spec = spec_or_none(robot.driver)
    declared = spec.all_of(GoodWhile) if spec else ()
    lease = lease_of(robot) if declared else None
    if lease is None or lease.state_at is None or now - lease.state_at > FRESH:
        return []
    values = lease.state.get("values") or {}
    found: list[tuple[Job, GoodWhile]] = []
    for good in declared:
        value = values.get(good.channel)
        if isinstance(value, int | float):
            asked = waiting.filter(kind=good.kind, asked_at__lt=lease.state_at - LATER)
            found += [(job, good) for job in asked if job.args.get(good.argument, value) != value]
    return found


def head_of(robot: Robot, link: QueueRobot) -> Job | None:
    """Return the robot's waiting job with the least start tag whose asker may still ask for it.

    None while the robot's package, which alone knows how to begin a job, is not installed.
    """
    waiting = Job.objects.filter(robot=robot, state=JobState.WAITING, start_tag__isnull=False)
    if not waiting.exists() or not job_kinds(robot):
        return None
    there = waiting.exclude(_any(refusals(robot, link.guests_ask)))
    return there.select_related("robot", "account", "user").order_by("start_tag", "id").first()
