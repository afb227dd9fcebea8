"""Estimates for a person who waits: the people and jobs ahead, and the length of the wait. It changes no row."""

from datetime import datetime
from typing import Any

from django.db.models import BigAutoField, Count, FloatField, Q, QuerySet, Sum

from queueing import fairshare
from queueing.jobs.forecasts import any_waits, jobs_before, jobs_take, left_of_turn, length_of_handover
from queueing.models import NOT_YET, Job, JobState, Queue, Ticket, TicketState
from queueing.rows import QUEUE, link_of
from queueing.turns import length_of_turn
from robots.models import Robot
from robots.prepared import Prepared, Slot
from robots.states import Cycle

People = tuple[int, int]  # how many, and how many times as long as usual their turns are, added up
NOBODY: People = (0, 0)
TAG, TICKET = Slot("tag", FloatField()), Slot("ticket", BigAutoField())
_AHEAD: Prepared[Any] = Prepared(
    lambda: (
        Ticket.objects.filter(queue=QUEUE, state__in=NOT_YET)
        .filter(Q(start_tag__lt=TAG) | Q(start_tag=TAG, pk__lt=TICKET))
        .order_by()
        .values("queue")
        .annotate(number=Count("pk"), lengths=Sum("user__turn_factor"))
        .values_list("number", "lengths")
    )
)


def waiting(robot: Robot) -> int:
    """Return how many people wait for the robot, or for a job on it."""
    people = Ticket.objects.filter(queue__robot_links__robot=robot, state__in=NOT_YET).count()
    return people + Job.objects.filter(robot=robot, state=JobState.WAITING).count()


def waiting_people(queue: Queue) -> QuerySet[Ticket]:
    """Return the places of the people who wait or have an offer, in the order in which they will be served."""
    return Ticket.objects.filter(queue=queue, state__in=NOT_YET).select_related("user").order_by("start_tag", "pk")


def place_and_wait(robot: Robot, ticket: Ticket, now: datetime) -> tuple[int, tuple[int, int] | None]:
    """Return how many waiting people and jobs are served before the ticket, and its least and greatest wait (s).

    Nobody is before a ticket that no longer waits. The wait is None if it is not known.
    """
    if ticket.state != TicketState.WAITING:
        return 0, _wait(robot, ticket.queue, NOBODY, None, now)
    people = _AHEAD.first(queue=ticket.queue_id, tag=ticket.start_tag, ticket=ticket.pk) or NOBODY
    jobs = jobs_before(ticket)
    return people[0] + len(jobs), _wait(robot, ticket.queue, people, jobs, now)


def wait_if_joined(robot: Robot, now: datetime) -> tuple[int, int] | None:
    """Return the least and greatest wait (s) behind everybody who waits now; None if it is not known.

    Somebody who has driven little may come before some of them.
    """
    link = link_of(robot)
    if link is None:  # nobody has ever joined
        return fairshare.estimate(*NOBODY, 0.0, length_of_turn(robot), length_of_handover(robot))
    waiting_now = Ticket.objects.filter(queue=link.queue_id, state__in=NOT_YET)
    found = waiting_now.aggregate(number=Count("pk"), lengths=Sum("user__turn_factor"))
    people = found["number"], found["lengths"] or 0
    jobs = list(Job.objects.filter(queue=link.queue_id, state=JobState.WAITING)) if any_waits(link.queue_id) else []
    return _wait(robot, link.queue, people, jobs, now)


def _wait(robot: Robot, queue: Queue, people: People, jobs: list[Job] | None, now: datetime) -> tuple[int, int] | None:
    """Return the wait behind these people and jobs; `jobs` None: nor behind the one that runs."""
    if queue.paused or robot.cycle in (Cycle.FAULT, Cycle.LOCKED_OUT, Cycle.OFFLINE):
        return None
    left = left_of_turn(robot, now) or 0.0
    low, high = fairshare.estimate(*people, left, length_of_turn(robot), length_of_handover(robot))
    of_jobs = (0.0, 0.0) if jobs is None else jobs_take(robot, jobs, now)
    return round(low + of_jobs[0]), round(high + of_jobs[1])
