"""Advances the queues: ends turns and offers whose time is over, and offers robots to the next people."""

import logging
from collections.abc import Callable, Iterable
from datetime import datetime, timedelta
from functools import partial

from django.db import Error, transaction
from django.db.models import DateTimeField, Exists, OuterRef, Q, QuerySet

from queueing.jobs.judging import judge_waiting
from queueing.jobs.running import settle as settle_jobs
from queueing.models import OPEN_JOB, OPEN_TICKET, Job, PlaceEnd, Queue, Ticket, TicketState, Turn
from queueing.offers import REACHABLE, made_at, open_offers, reachable, recall, recall_offers, was_away
from queueing.rows import QUEUE, BadSettings, lock, queue_of, robots_of
from queueing.serving import serve_next
from queueing.tickets import dismiss_unfit, withdraw
from queueing.turns import ALWAYS, tick_turn
from robots.grants import end_overdue_single
from robots.models import Grant, Robot
from robots.prepared import Prepared, Slot
from robots.states import Cycle

log = logging.getLogger(__name__)
ABSENT_S = 900  # a person who waits and is away this long loses the place
QUIET_S = 5  # period for queues with nothing open
SINCE = Slot("since", DateTimeField())
_ALL: Prepared[Queue] = Prepared(lambda: Queue.objects.all())
_BUSY: Prepared[Queue] = Prepared(lambda: busy_queues())
_WITHOUT_QUEUE: Prepared[Robot] = Prepared(lambda: Robot.objects.filter(enabled=True, queue_link=None))
_TURNS: Prepared[Turn] = Prepared(
    lambda: Turn.objects.select_related("grant", "ticket", "user").filter(robot__queue_link__queue=QUEUE, ended_at=None)
)
_ABSENT: Prepared[Ticket] = Prepared(
    lambda: (
        Ticket.objects.annotate(reachable=reachable())
        .filter(queue=QUEUE, state=TicketState.WAITING, last_seen__lte=SINCE, reachable=False)
        .exclude(offer_until__gt=SINCE)  # the offer that passed; a browser may have told it just now
    )
)
RESTING = (Cycle.OFFLINE, Cycle.READY, Cycle.FAULT, Cycle.LOCKED_OUT)


def tick(now: datetime, up_since: datetime = ALWAYS) -> None:
    """Advance every queue: end, expire, extend, offer. Safe to run twice at once.

    `up_since`: people can reach the portal since then; nobody counts as absent before.
    """
    _give_queues()
    _each(_ALL(), partial(_tick, up_since=up_since), now)


def tick_seldom(now: datetime, up_since: datetime = ALWAYS) -> None:
    """Do the same, but for queues with nothing open only every fifth second, so that an idle portal costs little.

    In those nothing can end or expire; only the next thing may start.
    """
    busy = _BUSY()
    _each(busy, partial(_tick, up_since=up_since), now)
    if now.second % QUIET_S:
        return
    _give_queues()
    _each([queue for queue in _ALL() if queue not in busy and not queue.paused], serve_next, now)


def _give_queues() -> None:
    """Give a queue to each enabled robot that has none, so that its own behaviour runs before anybody asks."""
    for robot in _WITHOUT_QUEUE():
        try:
            queue_of(robot)
        except BadSettings as error:
            log.error("%s has no queue: %s", robot, error)
        except Error:
            raise
        except Exception:
            log.exception("%s has no queue", robot)


def busy_queues() -> QuerySet[Queue]:
    """Return the queues with an open ticket, turn, job or grant, or with a robot in its turn cycle."""
    mine: Q = Q(robot__queue_link__queue=OuterRef("pk"))
    return Queue.objects.filter(
        Exists(Ticket.objects.filter(queue=OuterRef("pk"), state__in=OPEN_TICKET))
        | Exists(Job.objects.filter(queue=OuterRef("pk"), state__in=OPEN_JOB))
        | Exists(Turn.objects.filter(mine, ended_at=None))
        | Exists(Grant.objects.filter(mine, ended_at=None))
        | Exists(Robot.objects.filter(queue_link__queue=OuterRef("pk")).exclude(cycle__in=RESTING))
    )


def _expire(queue: Queue, now: datetime, up_since: datetime) -> None:
    """End the offers that nobody answered, and the places of people who are away."""
    for ticket in open_offers(queue):
        if ticket.offer_until is None or ticket.offer_until > now:
            continue
        if made_at(ticket) < up_since:
            recall(queue, ticket, ticket.robot)
        elif was_away(ticket):
            recall(queue, ticket, ticket.robot, passed=True)
        else:
            withdraw(queue, ticket, TicketState.EXPIRED, PlaceEnd.NO_ANSWER, now)
    absent = now - timedelta(seconds=ABSENT_S)
    if up_since <= absent:
        for ticket in _ABSENT(queue=queue.pk, since=absent, reachable=now - REACHABLE):
            withdraw(queue, ticket, TicketState.EXPIRED, PlaceEnd.AWAY, now)


def _each(queues: Iterable[Queue], do: Callable[[Queue, datetime], None], now: datetime) -> None:
    """Call `do` with each locked queue; an error in one, as in a robot's package, does not stop the others."""
    for queue in queues:
        try:
            with transaction.atomic():
                do(lock(queue), now)
        except Error:
            raise
        except Exception:
            log.exception("%s was left out", queue)


def _tick(queue: Queue, now: datetime, up_since: datetime) -> None:
    for robot in robots_of(queue):
        end_overdue_single(robot, now)
    dismiss_unfit(queue, now)
    for turn in _TURNS(queue=queue.pk):
        tick_turn(queue, turn, now, up_since)
    recall_offers(queue, now)  # before `_expire`, so that an offer that could not be accepted does not expire
    _expire(queue, now, up_since)
    settle_jobs(queue, now)
    judge_waiting(queue, now)  # after `settle_jobs`, which puts interrupted jobs back into the queue
    if not queue.paused:
        serve_next(queue, now, up_since)
