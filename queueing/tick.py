"""Time passes in the queues: what is over ends, and who is next is offered the robot."""

from datetime import datetime, timedelta

from django.db import transaction

from queueing.jobs.running import settle as settle_jobs
from queueing.models import Queue, Ticket, TicketState, Turn
from queueing.offers import recall_offers
from queueing.rows import locked, robots_of
from queueing.serving import serve_next
from queueing.tickets import dismiss_unfit, withdraw
from queueing.turns import tick_turn
from robots.grants import end_overdue_single

ABSENT_S = 900  # a waiting person who is away so long has left
NO_ANSWER = "did not answer the offer"


def tick(now: datetime) -> None:
    """Let time pass in every queue: end, expire, lengthen, offer. Safe to run twice at once."""
    for queue in Queue.objects.all():
        with transaction.atomic():
            _tick(locked(queue), now)


def _tick(queue: Queue, now: datetime) -> None:
    for robot in robots_of(queue):
        end_overdue_single(robot, now)
    dismiss_unfit(queue, now)
    for turn in Turn.objects.select_related("grant", "ticket", "user").filter(
        robot__queue_link__queue=queue, ended_at=None
    ):
        tick_turn(queue, turn, now)
    recall_offers(queue, now)  # first: an offer that nobody could take up must not lapse
    for ticket in Ticket.objects.filter(queue=queue, state=TicketState.OFFERED, offer_until__lte=now):
        withdraw(queue, ticket, TicketState.EXPIRED, NO_ANSWER, now)
    for ticket in Ticket.objects.filter(
        queue=queue, state=TicketState.WAITING, last_seen__lte=now - timedelta(seconds=ABSENT_S)
    ):
        withdraw(queue, ticket, TicketState.EXPIRED, "was away too long", now)
    settle_jobs(queue, now)
    if not queue.paused:
        serve_next(queue, now)
