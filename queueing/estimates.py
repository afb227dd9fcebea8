"""How many people and jobs are ahead of a person who waits, and how long the wait may be. Reads only."""

from datetime import datetime

from django.conf import settings

from queueing import fairshare
from queueing.jobs.foreseeing import jobs_before, jobs_take
from queueing.models import NOT_YET, Job, JobState, Ticket, TicketState, Turn
from robots.models import Robot
from robots.states import Cycle

RULES = settings.FARHAND
HANDOVER_S = 12.0


def waiting(robot: Robot) -> int:
    """Return how many people wait for the robot, or for a job on it."""
    people = Ticket.objects.filter(queue__robot_links__robot=robot, state__in=NOT_YET).count()
    return people + Job.objects.filter(robot=robot, state=JobState.WAITING).count()


def place(ticket: Ticket) -> int:
    """Return how many waiting people and jobs are served before this ticket."""
    return _people(ticket) + len(jobs_before(ticket))


def _people(ticket: Ticket) -> int:
    ahead = Ticket.objects.filter(queue=ticket.queue, state__in=NOT_YET)
    return (
        ahead.filter(start_tag__lt=ticket.start_tag).count()
        + ahead.filter(start_tag=ticket.start_tag, pk__lt=ticket.pk).count()
    )


def wait_range(robot: Robot, ticket: Ticket, now: datetime) -> tuple[int, int] | None:
    """Return the least and greatest wait of a ticket in s; None if nobody knows when the robot will be back."""
    if robot.cycle in (Cycle.FAULT, Cycle.LOCKED_OUT, Cycle.OFFLINE):
        return None
    turn = Turn.objects.filter(robot=robot, ended_at=None).first()
    left = max(0.0, (turn.until - now).total_seconds()) if turn else 0.0
    if turn:
        left = max(left, 0.0) if turn.until <= turn.base_until else float(RULES["COUNTDOWN_S"])
    waits = ticket.state == TicketState.WAITING
    people = _people(ticket) if waits else 0
    low, high = fairshare.estimate(people, left, float(robot.turn_s or RULES["TURN_S"]), HANDOVER_S)
    of_jobs = jobs_take(robot, jobs_before(ticket), now) if waits else (0.0, 0.0)
    return round(low + of_jobs[0]), round(high + of_jobs[1])
