"""Starts jobs, and settles them when their grant ends."""

from datetime import UTC, datetime

from django.conf import settings
from django.core.mail import EmailMessage
from django.db import transaction

from accounts.adapter import send_in_background
from queueing.charging import charge, follow_charge, serve
from queueing.charging import settle as settle_clock
from queueing.jobs.kinds import label_of, limit_of
from queueing.models import Job, JobRun, JobState, Queue
from queueing.rows import QUEUE, announce, link_of
from robots.grants import interruption, start_grant
from robots.models import Command, Grant, Robot
from robots.prepared import Prepared
from robots.sentences import english
from robots.services.commands import over_by, put
from robots.services.programs import is_program
from robots.states import CommandState, GrantEnd, GrantKind

LONGEST = 300  # characters of a reason
FAULTS = 3  # a job is started again this often after a fault of the robot
ONCE = "It is not begun again by itself, and costs nothing."
TOO_LONG = "It took longer than a job is allowed to."
AGAIN = "It goes on as soon as the robot can."
_RUNNING: Prepared[Job] = Prepared(
    lambda: Job.objects.filter(queue=QUEUE, state=JobState.RUNNING).select_related("account", "robot", "user")
)
PLACE_STAYS = "It keeps its place, has cost nothing so far, and goes on as soon as the robot can."


def promote(queue: Queue, job: Job, now: datetime) -> None:
    """Start the job: write grant, run and command in the caller's transaction; the owner is woken after it."""
    robot = job.robot
    limit_s = limit_of(robot, job.kind)
    grant = start_grant(robot, GrantKind.JOB, now, until=over_by(now, limit_s))
    JobRun.objects.create(job=job, grant=grant)
    Job.objects.filter(pk=job.pk).update(state=JobState.RUNNING, reason="")
    serve(queue, job.start_tag or 0.0)
    put(robot, grant, job.kind, job.args, limit_s, now, job.user, job.seen_picture_at)
    announce(queue)


def settle(queue: Queue, now: datetime) -> None:
    """End each job whose grant has ended, or put it back into the queue."""
    for job in _RUNNING(queue=queue.pk):
        run = job.last_run()
        if run is None:  # the grant was deleted
            end(queue, job, JobState.UNKNOWN, "Whether it was carried out is not known.", 0.0, now)
        elif run.grant.ended_at is not None:
            _settle(queue, job, run.grant, run.grant.commands.order_by("id").first(), now)


def _settle(queue: Queue, job: Job, grant: Grant, command: Command | None, now: datetime) -> None:
    state = command.state if command is not None else CommandState.EXPIRED
    reason = command.reason if command is not None else ""
    if command is not None and not command.final:
        return  # the robot is still coming to rest
    used = _used(grant, job.robot)
    stopped = Robot.objects.filter(pk=job.robot_id, stopped_at__gte=grant.opened_at).exists()
    if state == CommandState.COMPLETED:
        end(queue, job, JobState.DONE, "", used, now)
    elif state not in (CommandState.CANCELLED, CommandState.FAILED, CommandState.EXPIRED, CommandState.REJECTED):
        end(queue, job, JobState.UNKNOWN, reason or "Whether it was carried out is not known.", 0.0, now)
    elif job.cancel_asked_at is not None:
        end(queue, job, JobState.CANCELLED, "Cancelled.", used, now)
    elif stopped:
        end(queue, job, JobState.CANCELLED, "The robot was stopped.", used, now)
    elif command is not None and command.result.get("code"):  # the robot's own reason: a second run would end alike
        end(queue, job, JobState.FAILED, reason, used if state == CommandState.FAILED else 0.0, now)
    elif grant.end_code == GrantEnd.TIME_UP and state != CommandState.EXPIRED:
        reason = f"{TOO_LONG} {reason}".strip() if is_program(job.robot, job.kind) else TOO_LONG
        end(queue, job, JobState.FAILED, reason, used, now)
    elif command is not None and command.sent_at is not None and is_program(job.robot, job.kind):
        text = f"{reason} {ONCE}".strip()
        end(queue, job, JobState.FAILED, text if len(text) <= LONGEST else reason, 0.0, now)
    else:
        _wait_again(queue, job, grant, reason, now)


def _wait_again(queue: Queue, job: Job, grant: Grant, reason: str, now: datetime) -> None:
    """Put a job back that the robot's need or fault interrupted: it keeps its tag and costs nothing."""
    preempted = grant.end_code == GrantEnd.PREEMPTED
    faults = job.faults + (not preempted)
    if faults >= FAULTS:
        end(queue, job, JobState.FAILED, f"It was begun {faults} times in vain. {reason}", 0.0, now)
        return
    reason = f"{interruption(grant.pk)} {PLACE_STAYS}" if preempted else f"{reason} {AGAIN}"
    Job.objects.filter(pk=job.pk).update(state=JobState.WAITING, faults=faults, reason=reason[:LONGEST])
    announce(queue)


def _used(grant: Grant, robot: Robot) -> float:
    """Return the cost of the run in the unit of the robot's queue."""
    link = link_of(robot)
    if link is not None and link.charges_jobs:
        return 1.0
    ended = min(grant.ended_at or grant.opened_at, grant.until or datetime.max.replace(tzinfo=UTC))
    return max(0.0, (ended - grant.opened_at).total_seconds())


def end(
    queue: Queue, job: Job, state: JobState, reason: str, cost: float, now: datetime, code: str = ""
) -> None:  # fmt: skip
    """End a job, charge it, and notify its asker. `code`: the robot's own reason why the job never began."""
    open_one = Job.objects.filter(pk=job.pk, state=job.state)
    if not open_one.update(state=state, reason=reason[:LONGEST], code=code, ended_at=now, charged=cost):
        return
    if job.start_tag is not None and cost:
        charge(queue, job.account, job.start_tag, cost)
        job.account.refresh_from_db()
        follow_charge(job.account)
    settle_clock(queue)
    announce(queue, job.user)
    if job.mail and job.user is not None and job.user.is_active and job.user.email:
        _mail_on_commit(
            job, f"{label_of(job.robot, job.kind)}: {english(JobState(state).label).lower()}. {reason}".strip()
        )


def _mail_on_commit(job: Job, text: str) -> None:
    address = settings.SITE_ADDRESS + job.get_absolute_url()
    to = [job.user.email] if job.user is not None else []
    message = EmailMessage(f"Your job on {job.robot.full_name} has ended", f"{text}\n\n{address}\n", to=to)
    transaction.on_commit(lambda: send_in_background(message), robust=True)
