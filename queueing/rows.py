"""What every verb of the queue does first and last: lock its row, and say that it changed."""

from typing import Any

from queueing.models import Queue
from robots import bus
from robots.messages import Changed, StandingChanged
from robots.models import Robot


def locked(queue: Queue) -> Queue:
    """Return the queue with its row locked until the transaction ends."""
    return Queue.objects.select_for_update().get(pk=queue.pk)


def robots_of(queue: Queue) -> list[Robot]:
    """Return the robots that the queue serves."""
    return list(Robot.objects.filter(queue_link__queue=queue).order_by("pk"))


def announce(queue: Queue, user: Any = None) -> None:
    """Tell who watches its robots, who stands in it, and `user`, who came to it; once the transaction is through."""
    for robot in robots_of(queue):
        bus.publish_on_commit(robot.slug, Changed("queue"))
    bus.tell_people_on_commit(StandingChanged(queue=queue.pk, user=user.pk if user else 0))
