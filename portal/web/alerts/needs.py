"""Finds what robots need staff for now, from rows that others keep."""

from collections.abc import Iterator
from dataclasses import dataclass
from datetime import datetime, timedelta

from django.conf import settings
from django.db.models import Count

from portal.web.alerts.models import Kind
from queueing.services import waits_for_staff
from robots.grants import owner_alive
from robots.models import Incident, Robot
from robots.sentences import english
from robots.services.incidents import TRANSIENT
from robots.services.outages import CODE
from robots.services.programs import to_approve
from robots.states import Cycle

NEW_S = (
    1800.0  # an older incident needs nobody now: it was dealt with, or the robot is not ready, which is told by itself
)
STOPPED_S = 60.0  # the operator may release a stop before
TRANSIENT_S = 60.0  # what is tried again may end by itself, as at a start
REVIEW_S = 86_400.0
LONGEST = 300


@dataclass(frozen=True)
class Need:
    """What a robot needs staff for. `after_s`: staff are told when it has lasted so long (s)."""

    robot: Robot
    kind: Kind
    text: str
    after_s: float = 0.0
    subject: str = ""

    @property
    def key(self) -> tuple[int, str, str]:
        """Return what is the same for the same need later."""
        return self.robot.pk, str(self.kind), self.subject


def needs(now: datetime) -> dict[tuple[int, str, str], Need]:
    """Return what robots that are switched on need staff for, by key."""
    robots = Robot.objects.filter(enabled=True).select_related("lease")
    return {need.key: need for robot in robots for need in _of(robot, now)} | _reviews(now)


def _of(robot: Robot, now: datetime) -> Iterator[Need]:
    if robot.cycle != Cycle.LOCKED_OUT:  # staff did that themselves
        if not owner_alive(getattr(robot, "lease", None), now):
            yield _not_ready(robot, "The robot's worker does not answer.")
        elif robot.cycle in (Cycle.OFFLINE, Cycle.FAULT):
            yield _not_ready(robot, f"{english(Cycle(robot.cycle).label)}. {robot.reason}".strip())
    if robot.stop_latched:
        yield Need(robot, Kind.STOPPED, "It was stopped, and the stop is not released.", STOPPED_S)
    elif waits_for_staff(robot):
        yield Need(robot, Kind.SUSPENDED, "After a stop its jobs wait until staff resume them.", _after_s())
    fresh = Incident.objects.filter(robot=robot, closed_at=None, at__gte=now - timedelta(seconds=NEW_S))
    fresh = fresh.exclude(code=CODE)  # told already: its worker does not answer
    for code, text, remedy in fresh.order_by("at").values_list("code", "text", "remedy")[:50]:
        after_s = TRANSIENT_S if remedy in TRANSIENT else 0.0
        yield Need(robot, Kind.INCIDENT, f"{text} {remedy}".strip()[:LONGEST], after_s, code)


def _not_ready(robot: Robot, text: str) -> Need:
    return Need(robot, Kind.NOT_READY, text[:LONGEST], _after_s())


def _after_s() -> float:
    return float(settings.ALERTS["AFTER_S"])


def _reviews(now: datetime) -> dict[tuple[int, str, str], Need]:
    waiting = to_approve().filter(changed_at__lt=now - timedelta(seconds=REVIEW_S)).order_by()
    rows = waiting.filter(robot__enabled=True).values_list("robot").annotate(n=Count("pk")).order_by()
    robots = Robot.objects.in_bulk([robot for robot, _ in rows])
    found = (
        Need(robots[pk], Kind.PROGRAMS, f"Shared programs that have waited for a review for a day: {count}.")
        for pk, count in rows
    )
    return {need.key: need for need in found}
