"""Moves the stamps of running and waiting rows when the time of day was set, or when the machine slept.

Everything that the queues judge by the time of day is in rows: the end of a turn or an offer, the last presence of a
person, the deadline of a command. The stamps move by as much as the clock, so all remaining times stay the same. Rows
that have ended keep their stamps.
"""

import logging
from collections.abc import Iterator
from datetime import datetime, timedelta
from typing import Any

from django.conf import settings
from django.contrib.sessions.models import Session
from django.core.cache import cache
from django.db import InterfaceError, OperationalError, transaction
from django.db.models import F, Max, QuerySet

from queueing.models import OPEN_JOB, OPEN_TICKET, Job, Queue, QueueRobot, Ticket, Turn, TurnSession
from queueing.rows import announce, lock
from robots.bus import web_uptime
from robots.kit.clock_steps import Step
from robots.models import Command, Grant, Lease, Robot

log = logging.getLogger(__name__)
SLACK = timedelta(seconds=1)


def carry(step: Step, now: datetime) -> None:
    """Move the stamps of all open rows. Raises OperationalError, InterfaceError: the database cannot be reachable.

    Any other error is logged, because no tick may stop for it.
    """
    try:
        with transaction.atomic():
            queues = [lock(queue) for queue in Queue.objects.order_by("pk")]
            _Move(step, now).everything()
            for queue in queues:
                announce(queue)
        web_uptime.forget()
        cache.clear()  # it counts attempts; after a step back some would be refused for too long
    except (OperationalError, InterfaceError):
        raise
    except Exception:
        log.exception("the queues could not follow the clock, which was set by %s", step.total)


class _Move:
    """Moves stamps, but not those written after the step, which happened within the last `since_s` seconds."""

    def __init__(self, step: Step, now: datetime) -> None:
        self._new = (now - timedelta(seconds=step.since_s) - SLACK, now + SLACK)
        self._moved, self._by = step.shift, step.shift + self._paused(step, now - step.shift)

    def _paused(self, step: Step, now: datetime) -> timedelta:
        """Return how long the portal stood still; other machines may have written rows while this one was off.

        `now` is by the clock before the step.
        """
        if not step.paused:
            return step.paused
        longest = step.paused
        for rows, stamp, *_ in _written():
            newest = rows.filter(**{f"{stamp}__lt": self._new[0]}).aggregate(newest=Max(stamp))["newest"]
            if newest is not None:
                longest = min(longest, now - newest)
        return max(longest, timedelta())

    def everything(self) -> None:
        """Move all stamps that the portal judges by the time of day."""
        for rows, stamp, *more in _written():  # the stamps in `more` move together with `stamp`
            old = rows.exclude(**{f"{stamp}__isnull": True}).exclude(**{f"{stamp}__range": self._new})
            old.update(**{name: F(name) + self._by for name in (stamp, *more)})
        offered = Ticket.objects.filter(state__in=OPEN_TICKET, offer_until__isnull=False)
        offered.update(offer_until=F("offer_until") + self._by)  # all older than the step: only ticks make offers
        self._ahead(Lease.objects.all(), "expires_at", settings.FARHAND["LEASE_S"], self._by)
        if self._moved:  # not after a sleep: a session ends at a time of day
            self._ahead(Session.objects.all(), "expire_date", settings.SESSION_COOKIE_AGE, self._moved)

    def _ahead(self, rows: QuerySet[Any], name: str, seconds: float, by: timedelta) -> None:
        """Move the end `name` of rows, each of which is renewed for `seconds`."""
        first, last = (at + timedelta(seconds=seconds) for at in self._new)
        old = rows.exclude(**{f"{name}__isnull": True}).exclude(**{f"{name}__range": (first, last)})
        old.update(**{name: F(name) + by})


def _written() -> Iterator[tuple[Any, ...]]:
    """Yield open rows, the name of a stamp that holds when it was written, and names of stamps that move with it."""
    turns, commands = Turn.objects.filter(ended_at=None), Command.objects.filter(grant__ended_at=None)
    tickets, jobs = Ticket.objects.filter(state__in=OPEN_TICKET), Job.objects.filter(state__in=OPEN_JOB)
    yield turns, "started_at", "base_until", "until"
    yield from ((turns, name) for name in ("last_seen", "acted_at"))
    yield TurnSession.objects.all(), "last_seen"
    yield from ((tickets, name) for name in ("joined_at", "last_seen"))
    yield from ((jobs, name) for name in ("asked_at", "cancel_asked_at"))
    yield from ((commands, name) for name in ("accepted_at", "sent_at", "acknowledged_at", "ended_at"))
    yield commands, "created_at", "deadline"
    yield Grant.objects.filter(ended_at=None), "opened_at", "until"
    yield from ((QueueRobot.objects.all(), name) for name in ("watched_at", "resumed_at"))
    yield Robot.objects.all(), "stopped_at", "rests_by"
    yield from ((Robot.objects.all(), name) for name in ("probe_asked_at", "probe_begun_at"))
    yield Lease.objects.all(), "state_at"
