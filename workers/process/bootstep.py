"""Celery bootsteps: a worker started for a robot opens it at start and closes it at stop.

Only a worker with FARHAND_ROBOT in its environment owns a robot; the housekeeping worker is an ordinary one.
The lease is taken before the consumer exists, so a worker that waits for the lease consumes no wake-up.
"""

import contextlib
import logging
import os
from functools import partial
from typing import TYPE_CHECKING, Any

from celery import bootsteps, signals
from celery.worker import state

from robots import bus
from workers.housekeeping.schedule import Schedule
from workers.process.queues import forget_earlier

if TYPE_CHECKING:
    from workers.process.wiring import Owner

log = logging.getLogger(__name__)
owner: "Owner | None" = None


def listen(worker: Any, queue: str, on: bool) -> None:
    """Start or stop to consume a queue; the consumer's own thread does it.

    If the broker is away, the consumer starts later with the queues that are selected then.
    """

    def follow() -> None:
        consumer = worker.consumer
        with contextlib.suppress(*consumer.connection_errors, AttributeError):  # no consumer, no connection
            (consumer.add_task_queue if on else consumer.cancel_task_queue)(queue)

    queues = worker.app.amqp.queues
    queues.select_add(queues[queue]) if on else queues.deselect(queue)
    worker.consumer.call_soon(follow)


class OwnRobot(bootsteps.StartStopStep):
    """Makes this worker the owner of one robot."""

    requires = ("celery.worker.components:Pool",)

    def __init__(self, worker: Any, **kwargs: Any) -> None:
        self.slug = os.environ.get("FARHAND_ROBOT", "")
        self.enabled = bool(self.slug)
        super().__init__(worker, **kwargs)

    def start(self, worker: Any) -> None:
        """Wait for the lease, then open the robot and consume its queue."""
        global owner
        from workers.process.wiring import Owner  # noqa: PLC0415 - a worker without a robot needs none of it

        made = Owner(self.slug, listen=partial(listen, worker))
        if not made.own(lambda: state.should_stop is not None or state.should_terminate is not None):
            raise SystemExit(0)
        made.threads.end_with_any()
        forget_earlier(self.slug, made.lease.epoch)
        queues = worker.app.amqp.queues
        # by its own exchange, not by the one that all share, which would remember the queue of each epoch for ever
        queues.select_add(queues[bus.queue_name(self.slug, made.lease.epoch)])
        made.start()
        owner = made

    def stop(self, worker: Any) -> None:
        """Hold the robot, then let Celery shut down."""
        if owner is not None:
            owner.stop()

    def terminate(self, worker: Any) -> None:
        """Hold the robot at once."""
        self.stop(worker)


STEPS = (OwnRobot, Schedule)


@signals.celeryd_init.connect
def _add(instance: Any, **_: object) -> None:
    """Give the steps to a worker that begins."""
    instance.app.steps["worker"].update(STEPS)
