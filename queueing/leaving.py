"""Ends the turn, places and jobs of a person who signs out, may no longer drive, or whose account is deleted."""

from datetime import datetime
from enum import Enum
from typing import Any

from django.conf import settings
from django.contrib.sessions.models import Session
from django.db import transaction
from django.db.models.signals import pre_delete
from django.dispatch import receiver

from queueing.jobs.asking import Asker
from queueing.jobs.own import cancel
from queueing.models import OPEN_JOB, OPEN_TICKET, Job, PlaceEnd, Ticket, Turn, TurnSession
from queueing.tickets import remove
from queueing.turns import end_turn
from robots.grants import end_grants_of
from robots.kit.clock import SYSTEM
from robots.models import Recording
from robots.recordings.keeping import forget_names
from robots.states import GrantEnd


class Place(Enum):
    """The consequence for place and turn when a session of the person ends."""

    KEPT = "kept"
    OTHERS = "goes on only where another session of theirs drives"
    TURN_ENDS = "the turn ends, a place in the queue is kept"
    LOST = "both are lost"


@receiver(pre_delete, sender=settings.AUTH_USER_MODEL)
def leave_everything(instance: Any, **_: Any) -> None:
    """End turns, places, jobs and grants of an account that is deleted, so that no robot still moves for it."""
    now = SYSTEM.now()
    for ticket in Ticket.objects.filter(user=instance, state__in=OPEN_TICKET):
        remove(ticket, now, PlaceEnd.DELETED, GrantEnd.UNFIT)
    for job in Job.objects.filter(user=instance, state__in=OPEN_JOB):
        cancel(job, Asker(user=instance), now)
    end_grants_of(instance, PlaceEnd.DELETED, now)
    recordings = list(Recording.objects.filter(grant__holder=instance).values_list("pk", flat=True))
    transaction.on_commit(lambda: forget_names(recordings), robust=True)


def last_report_elsewhere(slug: str, person: int, session: str, now: datetime) -> datetime | None:
    """Return when the operator's page last reported in another open session of theirs; None if there is none."""
    alive = Session.objects.filter(expire_date__gt=now).exclude(pk=session)
    mine = TurnSession.objects.filter(turn__robot__slug=slug, turn__user=person, turn__ended_at=None)
    found = mine.filter(session__in=alive.values("pk")).order_by("-last_seen").first()
    return found.last_seen if found else None


def note_open_session(person: int, session: str, now: datetime) -> None:
    """Note that the session in which the person accepted their turn still has a page open."""
    TurnSession.objects.filter(turn__user=person, turn__ended_at=None, session=session).update(last_seen=now)


def mark_disconnected(slug: str, person: int, now: datetime) -> None:
    """Mark the person's turn on the robot as disconnected."""
    turns = Turn.objects.filter(robot__slug=slug, user=person, ended_at=None, classic=False)
    turns.update(connected=False, last_seen=now)


def end_session(slug: str, person: int, place: Place, reason: str, now: datetime) -> None:
    """End the person's turn on the robot, or remove them from its queue, as `place` says.

    With `OTHERS` the caller has marked the turn as disconnected a moment before; a session that still drives removes
    that mark.
    """
    if place is Place.LOST:
        ticket = Ticket.objects.filter(queue__robot_links__robot__slug=slug, user=person, state__in=OPEN_TICKET).first()
        if ticket is not None:
            remove(ticket, now, PlaceEnd(reason), GrantEnd.UNFIT)
        return
    turns = Turn.objects.filter(robot__slug=slug, user=person, ended_at=None)
    if place is Place.OTHERS:
        turns = turns.filter(classic=False, connected=False)
    turn = turns.first() if place is not Place.KEPT else None
    if turn is not None:
        end_turn(turn, GrantEnd.SIGNED_OUT, reason, now)
