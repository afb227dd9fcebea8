"""Take a lapsed lease again in the same process: everything under the old epoch ends before the new one begins."""

import contextlib
from collections.abc import Callable
from typing import TYPE_CHECKING

from robots import bus
from robots.drivers.errors import RobotError
from robots.messages import Notice
from workers import ledger

if TYPE_CHECKING:
    from workers.runtime import Runtime

Listen = Callable[[str, bool], None]
BACK = "The robot's worker lost the robot for a moment and has it again. Look at the picture, then go on."


def regain(runtime: "Runtime", listen: Listen) -> None:
    """Get the robot back, called by the control loop while no command runs; leave where another has it.

    In this order: the old queue is let go, the robot is held, the epoch is raised, what was begun
    ends `unknown`, the driver is opened anew, the new queue is listened to.
    """
    lease, old = runtime.lease, bus.queue_name(runtime.robot.slug, runtime.lease.epoch)
    listen(old, False)
    state = runtime.driver.latest()
    moved = state is None or state.moving
    if moved and runtime.reach.connected:
        with contextlib.suppress(RobotError):
            runtime.driver.hold()
    if not lease.regain():
        runtime.guard.leave()
        return
    interrupted = ledger.abandon(runtime.robot, runtime.now())
    runtime.driver.close()
    runtime.reach.connected = False
    runtime.renew_driver()
    with runtime.taking(30.0):
        runtime.reach.connect(untouched=not (moved or interrupted))
    ledger.tidy(runtime.robot, lease.epoch, runtime.now())
    listen(bus.queue_name(runtime.robot.slug, lease.epoch), True)
    if interrupted or moved:
        bus.publish(runtime.robot.slug, Notice(BACK, "warning"))
