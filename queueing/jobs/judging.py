"""Judges waiting jobs again: by the rule of asking (`kinds.may_ask`), and by what the robot tells meanwhile."""

from datetime import datetime

from django.db.models import Q

from accounts.services import cleared_people
from queueing.jobs.foreseeing import any_waits
from queueing.jobs.kinds import job_kinds_or_none
from queueing.jobs.outdated import outdated
from queueing.jobs.running import end
from queueing.models import Job, JobState, Queue
from queueing.rows import links_of
from robots.kit.contract.spec import CommandKind
from robots.models import Robot

SWITCHED_OFF = "The account of the person who asked for it is switched off."
NO_SUCH_KIND = "This robot no longer takes this kind of job."
NO_GUESTS = "This robot no longer takes jobs from guests."
NOT_CLEARED = "The person who asked for it is no longer cleared for this robot."
NOTHING_KNOWN = Q(pk=None)  # of no job


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
        for job, good in outdated(link.robot, of_robot, now):
            end(queue, job, JobState.FAILED, good.text, 0.0, now, good.code)


def unfit(robot: Robot, guests_ask: bool) -> Q:
    """Return which waiting jobs of the robot may not start, because their asker may no longer ask for them."""
    return _any(refusals(robot, guests_ask))


def refusals(robot: Robot, guests_ask: bool) -> tuple[tuple[Q, str], ...]:
    """Return which jobs of the robot may no longer be asked for, and why, as a sentence each.

    Nothing is said of kinds and clearances while the robot's package is not installed.
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
    both = NOTHING_KNOWN
    for rule, _ in rules:
        both |= rule
    return both
