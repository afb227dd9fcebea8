"""Finds and locks the rows of a queue, and announces changes."""

from typing import Any

from django.core.exceptions import ValidationError
from django.db import transaction
from django.db.models import BigAutoField

from queueing.models import Queue, QueueRobot
from robots import bus
from robots.grants import ROBOT
from robots.kit.packets import Changed, StandingChanged
from robots.models import Robot
from robots.prepared import Prepared, Slot

QUEUE = Slot("queue", BigAutoField())
_ROBOTS: Prepared[Robot] = Prepared(
    lambda: Robot.objects.filter(queue_link__queue=QUEUE).only("slug", "clearance_required").order_by("pk")
)
_LINK: Prepared[QueueRobot] = Prepared(lambda: QueueRobot.objects.select_related("queue").filter(robot=ROBOT))
_LINKS: Prepared[QueueRobot] = Prepared(
    lambda: QueueRobot.objects.select_related("robot").filter(queue=QUEUE).order_by("robot_id")
)
_LOCKED: Prepared[Queue] = Prepared(lambda: Queue.objects.select_for_update().filter(pk=QUEUE))
SETTINGS = frozenset({"offers_turns", "guests_ask", "charged_in", "rest_after_min"})


class BadSettings(ValueError):
    """`[queue]` of a robot's robot.toml is wrong."""


def link_of(robot: Robot) -> QueueRobot | None:
    """Return the robot's settings in its queue; None if it has no queue yet."""
    return _LINK.first(robot=robot.pk)


def queue_of(robot: Robot) -> Queue:
    """Return the queue of the robot; a new robot gets one of its own, with the settings of its robot.toml.

    Raises BadSettings.
    """
    link = link_of(robot)
    if link is not None:
        return link.queue
    with transaction.atomic():
        queue = Queue.objects.create(name=f"Queue of {robot.name}")
        link = QueueRobot(robot=robot, queue=queue, **_first_settings(robot))
        try:
            link.full_clean()
        except ValidationError as error:
            raise BadSettings(f"robot.toml of {robot.driver}, [queue]: {'; '.join(error.messages)}") from error
        link.save()
        return queue


def _first_settings(robot: Robot) -> dict[str, Any]:
    """Return the table `[queue]` of the robot's robot.toml; nothing if its package is not installed."""
    try:
        table: dict[str, Any] = dict(robot.description().get("queue", {}))
    except (ImportError, LookupError, OSError):
        return {}
    if unknown := sorted(table.keys() - SETTINGS):
        raise BadSettings(f"robot.toml of {robot.driver}, [queue]: there is no setting {unknown[0]!r}")
    return table


def lock(queue: Queue) -> Queue:
    """Lock the queue's row until the transaction ends. Return the queue."""
    found = _LOCKED.first(queue=queue.pk)
    if found is None:
        raise Queue.DoesNotExist
    return found


def robots_of(queue: Queue) -> list[Robot]:
    """Return the robots of the queue; only their slug and `clearance_required` are loaded at once."""
    return _ROBOTS(queue=queue.pk)


def links_of(queue: Queue) -> list[QueueRobot]:
    """Return the queue's settings for each of its robots, in their order."""
    return _LINKS(queue=queue.pk)


def announce(queue: Queue, user: Any = None) -> None:
    """Announce a change of the queue, after the transaction, to viewers of its robots, people in it, and `user`."""
    for robot in robots_of(queue):
        bus.publish_on_commit(robot.slug, Changed("queue"))
    bus.tell_people_on_commit(StandingChanged(queue=queue.pk, user=user.pk if user else 0))


def is_suspended(robot: Robot, link: QueueRobot | None) -> bool:
    """Return whether nothing may start by itself: a stop is latched, or staff have not resumed since the last one."""
    if robot.stop_latched:
        return True
    resumed = link.resumed_at if link is not None else None
    return robot.stopped_at is not None and (resumed is None or resumed < robot.stopped_at)
