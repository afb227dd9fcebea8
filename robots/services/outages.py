"""Outages: a robot whose worker is silent for long gets an incident; what is over by itself is closed by itself.

A lost line needs no other incident: the worker opens one at once.
"""

from datetime import datetime, timedelta

from django.db.models import Q

from robots.grants import owner_alive
from robots.models import Incident, Robot
from robots.services.incidents import TRANSIENT, incident
from robots.states import Cycle

CODE = "outage"
LONG = timedelta(minutes=2)  # a worker that is started again is back sooner
TEXT = "The robot's worker does not answer."
RESTARTED = "The supervisor starts it again."
OVER = "It was over by itself."
_SILENCE, _ENDS_BY_ITSELF = Q(code=CODE), Q(remedy__in=TRANSIENT)


def note_outages(now: datetime) -> None:
    """Open an incident for each robot that is on and whose worker has been silent for long; close what is over."""
    for robot in Robot.objects.select_related("lease"):
        if robot.enabled and not owner_alive(getattr(robot, "lease", None), now):
            _note_silence(robot, now)
            continue
        if robot.silent_since is not None:
            Robot.objects.filter(pk=robot.pk).update(silent_since=None)
        in_order = robot.enabled and robot.cycle != Cycle.FAULT and not robot.reason
        _close(robot, _SILENCE | _ENDS_BY_ITSELF if in_order else _SILENCE, now)


def _note_silence(robot: Robot, now: datetime) -> None:
    since = robot.silent_since
    if since is None or since > now:  # the time of day may have been set back
        Robot.objects.filter(pk=robot.pk).update(silent_since=now)
    elif now - since >= LONG and not Incident.objects.filter(robot=robot, code=CODE, closed_at=None).exists():
        incident(robot, CODE, TEXT, since, remedy=RESTARTED)


def _close(robot: Robot, which: Q, now: datetime) -> None:
    for one in Incident.objects.filter(which, robot=robot, closed_at=None):
        told = f"{one.remedy} {OVER}"[:300]
        Incident.objects.filter(pk=one.pk, closed_at=None).update(closed_at=now, remedy=told)
