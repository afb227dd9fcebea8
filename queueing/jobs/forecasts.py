"""The order in which open jobs will probably be served, and how long each may wait. It changes no row."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime

from django.db.models import QuerySet

from queueing.fairshare import Range, turns_range
from queueing.jobs.kinds import limit_of
from queueing.models import NOT_YET, OPEN_JOB, Job, JobRun, JobState, QueueRobot, Ticket, Turn
from queueing.rows import QUEUE, is_suspended, link_of, links_of
from queueing.turns import countdown_s, length_of_turn
from robots.grants import ROBOT, open_grant
from robots.models import Robot
from robots.prepared import Prepared
from robots.states import Cycle, GrantKind

LATEST = 20  # ended jobs from which the duration of a job is estimated
OUT = (Cycle.FAULT, Cycle.LOCKED_OUT, Cycle.OFFLINE)
HANDOVER_S, LEAST_LEFT_S = 12.0, 5.0
_TURN: Prepared[Turn] = Prepared(
    lambda: Turn.objects.select_related("user").filter(robot=ROBOT, ended_at=None).order_by("pk")[:1]
)
_WAITING: Prepared[Job] = Prepared(lambda: Job.objects.filter(queue=QUEUE, state=JobState.WAITING).only("pk")[:1])
_RUNNING: Prepared[Job] = Prepared(lambda: _of(JobState.RUNNING)[:1])
_OPEN: Prepared[Job] = Prepared(lambda: _of(*OPEN_JOB).select_related("account", "queue", "robot"))


def _of(*states: str) -> QuerySet[Job]:
    return Job.objects.filter(robot=ROBOT, state__in=states).order_by("pk")


@dataclass(frozen=True)
class Forecast:
    """A job, the number of requests before it, and its least and greatest wait in s; None if it is not known."""

    job: Job
    ahead: int
    wait_s: tuple[int, int] | None


def in_order(robot: Robot) -> list[Job]:
    """Return the robot's open jobs, first the one that runs, then in the order in which they will be served."""
    return list(_tagged(robot, link_of(robot)))


def forecast(robot: Robot, now: datetime) -> list[Forecast]:
    """Return the robot's open jobs in the same order, each with its wait."""
    link = link_of(robot)
    tags = _tagged(robot, link)
    jobs = list(tags)
    if not jobs:
        return []
    each = durations(robot, jobs[0].kind)
    turns, turn_s, handover_s = _turns(jobs[0].queue_id), length_of_turn(robot), length_of_handover(robot)
    known = _known(robot, link, jobs)
    low, high = _left(jobs[0], each, now)
    turn_left = left_of_turn(robot, now)
    if turn_left is not None:  # the turn may end at any time
        low, high = low + handover_s[0], high + turn_left + handover_s[1]
    found: list[Forecast] = []
    for number, job in enumerate(jobs):
        running = job.state == JobState.RUNNING
        before = [] if running else [length for tag, length in turns if tag <= tags[job]]
        least, most = turns_range(len(before), sum(before), turn_s, handover_s)
        wait = (round(low + least), round(high + most))
        found.append(Forecast(job, number + len(before), (0, 0) if running else wait if known else None))
        if not running:
            low, high = low + each[0], high + each[1]
    return found


def any_waits(queue: int) -> bool:
    """Return whether a job waits in the queue with this number."""
    return bool(_WAITING(queue=queue))


def length_of_handover(robot: Robot) -> Range:
    """Return the least and greatest time of a handover (s): the robot may tidy up."""
    return HANDOVER_S, HANDOVER_S + robot.tidying_s()


def left_of_turn(robot: Robot, now: datetime) -> float | None:
    """Return the greatest rest of the robot's turn (s), if others wait; None if none runs."""
    turn = _TURN.first(robot=robot.pk)
    if turn is None:
        return None
    if turn.until > turn.base_until:  # in its extra time
        return countdown_s(turn)
    return max(0.0, (turn.until - now).total_seconds())


def jobs_before(ticket: Ticket) -> list[Job]:
    """Return the waiting jobs of the ticket's queue that are served before it, without jobs that wait for staff."""
    if not any_waits(ticket.queue_id):
        return []
    found: list[Job] = []
    for link in links_of(ticket.queue):
        if is_suspended(link.robot, link):
            continue
        tags = _tagged(link.robot, link)
        found += [job for job, tag in tags.items() if _precedes(job, tag, ticket)]
    return found


def _precedes(job: Job, tag: float, ticket: Ticket) -> bool:
    if job.state != JobState.WAITING or job.user_id == ticket.user_id:  # one's own gave way to the ticket
        return False
    return (tag, job.asked_at) < (ticket.start_tag, ticket.joined_at)


def jobs_take(robot: Robot, jobs: Sequence[Job], now: datetime) -> Range:
    """Return the least and greatest time (s) until these jobs are done, and the one that runs on the robot."""
    first = _RUNNING.first(robot=robot.pk)
    low = high = 0.0
    if first is not None:
        low, high = _left(first, durations(robot, first.kind), now)
    for kind, number in Counter(job.kind for job in jobs).items():
        least, most = durations(robot, kind)
        low, high = low + number * least, high + number * most
    return low, high


def durations(robot: Robot, kind: str) -> Range:
    """Return the range in which most jobs of the robot last (s); from 0 to the kind's limit if none has ended."""
    runs = JobRun.objects.filter(
        job__robot=robot, job__state__in=(JobState.DONE, JobState.FAILED), grant__ended_at__isnull=False
    )
    times = [(r.grant.ended_at, r.grant.opened_at) for r in runs.select_related("grant").order_by("-id")[:LATEST]]
    took = sorted((end - begin).total_seconds() for end, begin in times if end is not None)
    if not took:
        return 0.0, limit_of(robot, kind)
    return took[len(took) // 4], took[(9 * len(took)) // 10]


def _cost(robot: Robot, link: QueueRobot | None, kind: str) -> float:
    return 1.0 if link is not None and link.charges_jobs else sum(durations(robot, kind)) / 2


def _tagged(robot: Robot, link: QueueRobot | None) -> dict[Job, float]:
    """Return the open jobs in order, each with its start tag, or with the tag that it will probably get."""
    jobs = _OPEN(robot=robot.pk)
    if not jobs:
        return {}
    tags = _tags(jobs, _cost(robot, link, jobs[0].kind))
    jobs.sort(key=lambda job: (job.state != JobState.RUNNING, tags[job.pk], job.pk))
    return {job: tags[job.pk] for job in jobs}


def _tags(jobs: Sequence[Job], cost: float) -> dict[int, float]:
    """Return the start tag of each job; for a job without a tag the one that it will probably get."""
    newest: dict[int, float] = {
        j.account_id: j.start_tag + cost / j.account.weighs(j.queue) for j in jobs if j.start_tag is not None
    }
    tags: dict[int, float] = {}
    for job in sorted(jobs, key=lambda j: j.pk):
        if job.start_tag is not None:
            tags[job.pk] = job.start_tag
            continue
        first = max(job.queue.virtual_time, job.account.finish_tag)
        tags[job.pk] = newest.get(job.account_id, first)
        newest[job.account_id] = tags[job.pk] + cost / job.account.weighs(job.queue)
    return tags


def _turns(queue: int) -> list[tuple[float, int]]:
    """Return the start tags of people who wait, and how many times as long as usual each person's turns are."""
    waiting: QuerySet[Ticket] = Ticket.objects.filter(queue=queue, state__in=NOT_YET)
    return list(waiting.values_list("start_tag", "user__turn_factor"))


def _known(robot: Robot, link: QueueRobot | None, jobs: Sequence[Job]) -> bool:
    """Return whether the wait can be estimated: the robot is in order, and no upkeep runs."""
    if robot.cycle in OUT or jobs[0].queue.paused or is_suspended(robot, link):
        return False
    grant = open_grant(robot)
    return grant is None or grant.kind != GrantKind.UPKEEP


def _left(first: Job, each: Range, now: datetime) -> Range:
    """Return how long the job that runs may still take; (0, 0) if none runs."""
    if first.state != JobState.RUNNING:
        return 0.0, 0.0
    run = first.last_run()
    if run is None:
        return each
    spent = (now - run.grant.opened_at).total_seconds()
    low, high = max(0.0, each[0] - spent), max(LEAST_LEFT_S, each[1] - spent)
    share = (run.grant.commands.values_list("progress", flat=True).first() or {}).get("share")
    if isinstance(share, int | float) and 0 < share <= 1:  # the robot reports its progress
        high = max(LEAST_LEFT_S, min(high, spent / share - spent))
    return min(low, high), high
