"""Keeps downtimes: compares the status of robots, as the status page tells it, with the rows that are open.

A robot that comes and goes has one downtime: one that is well for a moment goes on with the same row, and one that was
out of service for a moment has none.
"""

from datetime import datetime, timedelta

from django.db import IntegrityError, transaction
from django.db.models import Q, QuerySet

from portal.web.feeds.models import Downtime
from queueing.services import CLOSED
from robots.models import Robot
from robots.services.status import status_of
from robots.wall_clock import FIRST

LASTS = timedelta(minutes=2)  # a shorter one is told to nobody
WELL = timedelta(minutes=5)  # a robot that is out of service again before has not been back
KEPT = timedelta(days=400)


def follow(now: datetime) -> None:
    """Begin, change and end downtimes."""
    known = {one.robot_id: one for one in Downtime.objects.filter(ended_at=None)}
    for robot in Robot.objects.select_related("lease"):
        state, label, why = status_of(robot, now)
        if state not in CLOSED:
            _end(known.get(robot.pk), now)
        elif robot.pk in known:
            _change(known[robot.pk], label, why, now)
        elif robot.enabled or hasattr(robot, "lease"):  # one that was never switched on was not in service either
            _begin(robot, label, why, now)
    Downtime.objects.filter(ended_at__gte=FIRST, ended_at__lt=now - KEPT).delete()


def listed(now: datetime) -> QuerySet[Downtime]:
    """Return the downtimes that are over or have lasted for a while, with their robots; short ones are deleted."""
    lasts = Q(ended_at__isnull=False) | Q(began_at__lte=now - LASTS)
    return Downtime.objects.filter(lasts).select_related("robot")


def _begin(robot: Robot, label: str, why: str, now: datetime) -> None:
    last = Downtime.objects.filter(robot=robot, ended_at__gt=now - WELL).first()
    try:
        with transaction.atomic():
            if last is None:
                Downtime.objects.create(robot=robot, label=label, reason=why, began_at=now, changed_at=now)
            else:
                Downtime.objects.filter(pk=last.pk).update(ended_at=None, label=label, reason=why, changed_at=now)
    except IntegrityError:  # another process was quicker
        return


def _change(one: Downtime, label: str, why: str, now: datetime) -> None:
    if (one.label, one.reason) != (label, why):
        Downtime.objects.filter(pk=one.pk, ended_at=None).update(label=label, reason=why, changed_at=now)


def _end(one: Downtime | None, now: datetime) -> None:
    if one is None:
        return
    mine = Downtime.objects.filter(pk=one.pk, ended_at=None)
    if now - one.began_at < LASTS:
        mine.delete()
    else:
        mine.update(ended_at=now, changed_at=now, reason="")
