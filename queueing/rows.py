"""Finds and locks the rows of a queue, and announces changes."""

from typing import Any

from django.db import transaction

from queueing.models import Queue, QueueRobot
from robots import bus
from robots.messages import Changed, StandingChanged
from robots.models import Robot


def queue_of(robot: Robot) -> Queue:
    """Return the queue of the robot; a new robot gets one of its own."""
    link = QueueRobot.objects.select_related("queue").filter(robot=robot).first()
    if link is not None:
        return link.queue
    with transaction.atomic():
        queue = Queue.objects.create(name=f"Queue of {robot.name}")
        return QueueRobot.objects.create(robot=robot, queue=queue).queue


def locked(queue: Queue) -> Queue:
    """Return the queue with its row locked until the transaction ends."""
    return Queue.objects.select_for_update().get(pk=queue.pk)


def robots_of(queue: Queue) -> list[Robot]:
    """Return the robots that the queue serves."""
    return list(Robot.objects.filter(queue_link__queue=queue).order_by("pk"))


def announce(queue: Queue, user: Any = None) -> None:
    """Tell watchers of its robots, people in it, and `user` that the queue changed, after the transaction."""
    for robot in robots_of(queue):
        bus.publish_on_commit(robot.slug, Changed("queue"))
    bus.tell_people_on_commit(StandingChanged(queue=queue.pk, user=user.pk if user else 0))
