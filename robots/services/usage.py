"""Counters of a robot's use, of five minutes each; they name nobody."""

from datetime import datetime, timedelta

from django.db import IntegrityError, transaction
from django.db.models import F

from robots.grants import owner_alive
from robots.models import Robot, Usage
from robots.wall_clock import FIRST

SLOT = timedelta(minutes=5)
KEPT = timedelta(days=400)
LONGEST_S = 150.0  # the most that counts as online between two looks; in a longer gap nobody looked


def slot_of(now: datetime) -> datetime:
    """Return the beginning of the five minutes in which `now` lies."""
    return now - timedelta(minutes=now.minute % 5, seconds=now.second, microseconds=now.microsecond)


def note_usage(robot: int, at: datetime, online_s: float = 0.0, watching: int = 0, sent_bytes: int = 0) -> None:
    """Add to the counters of the five minutes that begin at `at`. `robot` is its primary key.

    It is no error if the robot was removed meanwhile.
    """
    counts = {"online_s": online_s, "watching": watching, "sent_bytes": sent_bytes}
    more = {name: F(name) + count for name, count in counts.items()}
    row = Usage.objects.filter(robot=robot, at=at)
    if row.update(**more):
        return
    try:
        with transaction.atomic():
            Usage.objects.create(robot_id=robot, at=at, **counts)
    except IntegrityError:  # another process was quicker, or the robot was removed
        row.update(**more)


def note_online(now: datetime, seconds: float) -> int:
    """Count the last `seconds` as online for each robot whose owner answers. Return the number of these robots."""
    answering = [r for r in Robot.objects.select_related("lease") if owner_alive(getattr(r, "lease", None), now)]
    for robot in answering:
        note_usage(robot.pk, slot_of(now), online_s=min(max(seconds, 0.0), LONGEST_S))
    return len(answering)


def forget_old_usage(now: datetime) -> int:
    """Delete counters that are older than 400 days. Return how many."""
    return Usage.objects.filter(at__gte=FIRST, at__lt=now - KEPT).delete()[0]
