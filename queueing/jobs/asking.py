"""Requests for jobs: permission, limits, and the new job's place."""

from dataclasses import dataclass
from datetime import datetime
from typing import Any

from django.db import IntegrityError, transaction

from accounts.handles import claims_role, is_taken
from queueing.charging import account_of, account_of_guests, tag_next
from queueing.errors import NotCleared, RobotUnavailable, TooManyJobs
from queueing.jobs.kinds import job_kinds, may_ask
from queueing.models import OPEN_JOB, Account, Job, Queue
from queueing.rows import announce, is_suspended, link_of, lock, queue_of
from queueing.turns import start_countdown
from robots.grants import lease_of
from robots.kit.contract.capabilities import JobCheck
from robots.kit.contract.errors import BadRequest
from robots.kit.contract.find import function, spec_of
from robots.kit.contract.values import check
from robots.kit.plain import one_line
from robots.models import Robot
from robots.services.clicks import with_program
from robots.services.commands import picture_time
from robots.services.streams import packets_of

LIMIT = 10  # open jobs per person and queue
LARGEST = 50  # open jobs of all guests of one network address
MOST, MOST_OF_GUESTS = 300, 200  # open jobs of a queue at which nobody, and no guest, may ask for another
LONGEST_NAME = 40  # characters
FULL = "The robot has as many jobs as it can take; come back later."
TOO_MANY = "You have {} open jobs on this robot; wait until one has ended, or cancel one."
ONE_A_GUEST = "You have an open job on this robot; wait until it has ended, or cancel it."


@dataclass(frozen=True)
class Asker:
    """The person who asks, or a guest: the hash of a cookie, and the network address."""

    user: Any = None
    guest: str = ""
    network: str = ""


def ask(
    robot: Robot, asker: Asker, kind: str, args: dict[str, Any], now: datetime, name: str = "", mail: bool = False,
    form: str = "", seen_ms: int = 0,
) -> Job:  # fmt: skip
    """Create a job that waits for its turn, or return the one that the same `form` has made.

    A job that names a saved program runs that program's present text. `seen_ms`: when the picture that the person saw
    was taken (ms since 1970); 0 if that is not known.

    Raises:
        NotCleared: this person, or guests, may not ask for this kind of job.
        BadRequest, OutOfWorkspace: no such job or program, wrong values, values that do not fit the robot's present
            state or its stream, or a name of a role or another person.
        RobotUnavailable: switched off by staff.
        TooManyJobs: the asker, or the queue, has as many open jobs as allowed.
    """
    if (made := job_of_form(robot, asker, form)) is not None:
        return made
    user, link = asker.user, link_of(robot)
    spec = next((k for k in job_kinds(robot) if k.kind == kind), None)
    if spec is None:
        raise BadRequest("This robot does not take this kind of job.")
    guests_ask = link is not None and link.guests_ask
    if not may_ask(robot, user, spec, guests_ask) or (user is None and not asker.guest):
        raise NotCleared("Pass the clearance test of this robot first." if user else "Sign in to ask for this.")
    if not robot.enabled:
        raise RobotUnavailable("This robot is switched off now; come back later.")
    if not isinstance(args, dict):
        raise BadRequest("The values of a job must be an object.")
    args = with_program(robot, user, kind, args)
    lease = lease_of(robot)
    check(robot.driver, kind, args, robot.driver_settings(), lease.present_state(robot.spec(), now) if lease else None)
    _refuse_by_stream(robot, kind, args)
    shown = _shown_name(user, name)
    with transaction.atomic():
        queue = lock(queue_of(robot))
        if (made := job_of_form(robot, asker, form)) is not None:  # by a press at the same moment
            return made
        account = account_of(queue, user) if user is not None else account_of_guests(queue, asker.network)
        _refuse_more(queue, account, asker)
        try:
            with transaction.atomic():
                job = Job.objects.create(
                    queue=queue, robot=robot, account=account, user=user, guest="" if user else asker.guest,
                    kind=kind, args=args, asked_at=now, mail=mail and user is not None,
                    shown_name=shown, form=form, seen_picture_at=picture_time(seen_ms, now),
                )  # fmt: skip
        except IntegrityError as error:  # the same guest asked twice at once
            raise TooManyJobs(ONE_A_GUEST) from error
        tag_next(queue)
        job.refresh_from_db()
        if job.start_tag is not None and not is_suspended(robot, link):
            start_countdown(queue, now, job)
        announce(queue, user)
        return job


def job_of_form(robot: Robot, asker: Asker, form: str) -> Job | None:
    """Return the asker's job that this form has created; `form` is empty for a request without a form."""
    if not form:
        return None
    return Job.objects.filter(robot=robot, user=asker.user, guest="" if asker.user else asker.guest, form=form).first()


def _refuse_by_stream(robot: Robot, kind: str, args: dict[str, Any]) -> None:
    """Let the robot's own check refuse a job that its stream shows to be impossible, before anybody waits for it."""
    for own in spec_of(robot.driver).all_of(JobCheck):
        if packets := packets_of(robot, own.stream):
            function(own.function)(kind, args, packets)


def _shown_name(user: Any, name: str) -> str:
    """Return the name for the page; empty for a guest. Raises BadRequest."""
    shown = one_line(name)[:LONGEST_NAME].strip() if user is not None else ""
    if shown and (claims_role(shown) or is_taken(shown, but=user.pk)):
        raise BadRequest(
            "The name on the page may not be that of a role, a robot or another person; choose another one."
        )
    return shown


def _refuse_more(queue: Queue, account: Account, asker: Asker) -> None:
    mine = Job.objects.filter(queue=queue, account=account, state__in=OPEN_JOB)
    if asker.user is None and mine.filter(guest=asker.guest).exists():
        raise TooManyJobs(ONE_A_GUEST)
    limit = LIMIT if asker.user is not None else LARGEST
    if mine.count() >= limit:
        raise TooManyJobs(TOO_MANY.format(limit) if asker.user is not None else "Too many jobs wait; try again later.")
    if Job.objects.filter(queue=queue, state__in=OPEN_JOB).count() >= (MOST if asker.user else MOST_OF_GUESTS):
        raise TooManyJobs(FULL)
