"""Moves the stamps of what runs and who waits when the time of day was set, or when the machine slept.

Everything that the queues judge by the time of day is in rows: until when a turn or an offer lasts, who was present
lately, which command is too late. With their stamps moved by as much as the clock was, nothing of it has changed. What
has ended keeps the stamps that it has.
"""

import logging
from datetime import datetime, timedelta
from typing import Any

from django.conf import settings
from django.contrib.sessions.models import Session
from django.core.cache import cache
from django.db import InterfaceError, OperationalError, transaction
from django.db.models import F, QuerySet

from queueing.models import OPEN_JOB, OPEN_TICKET, Job, Queue, QueueRobot, Ticket, Turn, TurnSession
from queueing.rows import announce, locked
from robots.clock_steps import Step
from robots.models import Command, Grant, Lease, Robot

log = logging.getLogger(__name__)
SLACK = timedelta(seconds=1)


def carry(step: Step, now: datetime) -> None:
    """Move the stamps of everything that is open. Raises OperationalError, InterfaceError: the database is away.

    Anything else that goes wrong is logged, for no tick may stop for it.
    """
    try:
        with transaction.atomic():
            queues = [locked(queue) for queue in Queue.objects.order_by("pk")]
            _Move(step, now).everything()
            for queue in queues:
                announce(queue)
        cache.clear()  # of attempts: some would be refused until the time that it was before
    except (OperationalError, InterfaceError):
        raise
    except Exception:
        log.exception("the queues could not follow the clock, which was set by %s", step.total)


class _Move:
    """Moves stamps but those that were written after the step, which lies somewhere in the last `since_s` seconds."""

    def __init__(self, step: Step, now: datetime) -> None:
        self._step, self._new = step, (now - timedelta(seconds=step.since_s) - SLACK, now + SLACK)

    def everything(self) -> None:
        """Move what the portal judges by the time of day."""
        self._rows(Turn.objects.filter(ended_at=None), "started_at", "base_until", "until")
        self._each(Turn.objects.filter(ended_at=None), "last_seen")
        self._each(TurnSession.objects.all(), "last_seen")
        self._each(Ticket.objects.filter(state__in=OPEN_TICKET), "joined_at", "last_seen", "offer_until")
        self._each(Job.objects.filter(state__in=OPEN_JOB), "asked_at", "cancel_asked_at")
        commands = Command.objects.filter(grant__ended_at=None)
        self._each(commands, "accepted_at", "sent_at", "acknowledged_at", "ended_at")
        self._rows(commands, "created_at", "deadline")
        self._rows(Grant.objects.filter(ended_at=None), "opened_at", "until")
        self._each(QueueRobot.objects.all(), "watched_at", "resumed_at")
        self._rows(Robot.objects.all(), "stopped_at", "rests_by")
        self._each(Robot.objects.all(), "probe_asked_at", "probe_begun_at")
        self._each(Lease.objects.all(), "state_at")
        self._ahead(Lease.objects.all(), "expires_at", settings.FARHAND["LEASE_S"], self._step.total)
        if self._step.moved:  # not by a sleep: sessions end at a time of day
            self._ahead(Session.objects.all(), "expire_date", settings.SESSION_COOKIE_AGE, self._step.moved)

    def _each(self, rows: QuerySet[Any], *names: str) -> None:
        for name in names:
            self._rows(rows, name)

    def _rows(self, rows: QuerySet[Any], stamp: str, *more: str) -> None:
        """Move `stamp`, and `more` of the same rows, where `stamp` is of before the step."""
        old = rows.exclude(**{f"{stamp}__isnull": True}).exclude(**{f"{stamp}__range": self._new})
        old.update(**{name: F(name) + self._step.total for name in (stamp, *more)})

    def _ahead(self, rows: QuerySet[Any], name: str, seconds: float, by: timedelta) -> None:
        """Move the end of what lasts so long from each renewal on."""
        first, last = (at + timedelta(seconds=seconds) for at in self._new)
        old = rows.exclude(**{f"{name}__isnull": True}).exclude(**{f"{name}__range": (first, last)})
        old.update(**{name: F(name) + by})
