"""Takes a lapsed lease again in the same process; everything under the old epoch ends first."""

import contextlib
from collections.abc import Callable

from robots import bus
from robots.kit.contract.errors import RobotError
from robots.kit.packets import Notice
from workers.authority.lane import Lane
from workers.commands import rows
from workers.guard.watch import Watch
from workers.process.queues import forget_earlier
from workers.robot.connection import Connection
from workers.robot.owned import OwnedRobot

Listen = Callable[[str, bool], None]
AWAY_S, PAUSE_S = 30.0, 5.0
BACK = "The robot's worker lost control of the robot for a moment and has it again. Look at the picture, then go on."


class Regain:
    """Takes the lease again; `listen` switches the Celery queue of an epoch on or off."""

    def __init__(
        self, owned: OwnedRobot, lane: Lane, beside: Lane, connection: Connection, watch: Watch, listen: Listen
    ) -> None:
        self._owned, self._lease, self._lane, self._beside = owned, lane.lease, lane, beside
        self._connection, self._watch, self._listen = connection, watch, listen

    def regain(self) -> None:
        """Take the lease again; the control loop calls this while no motion runs. End the process if another has it.

        In this order: stop consuming the old queue, hold the robot, raise the epoch, end started commands as `unknown`,
        open the driver again, consume the new queue. A command beside a motion is waited for and ends `unknown` too.
        """
        with self._lane.taking(AWAY_S), self._beside.paused(PAUSE_S):
            self._regain()

    def _regain(self) -> None:
        owned, lease, slug = self._owned, self._lease, self._owned.robot.slug
        self._listen(bus.queue_name(slug, lease.epoch), False)
        state = owned.driver.latest()
        moved = state is None or state.moving
        if moved and self._connection.connected:
            with contextlib.suppress(RobotError):
                owned.driver.hold()
        if not lease.regain():
            self._watch.leave("its lease is lost to another owner")
            return
        interrupted = rows.abandon(owned.robot, owned.now())
        owned.driver.close()
        self._connection.connected = False
        owned.renew_driver()
        self._connection.connect(untouched=not (moved or interrupted))
        rows.tidy(owned.robot, lease.epoch, owned.now(), self._lane.name)
        forget_earlier(slug, lease.epoch)
        self._listen(bus.queue_name(slug, lease.epoch), True)
        if interrupted or moved:
            bus.publish(slug, Notice(BACK, "warning"))
