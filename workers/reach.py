"""Reaching the robot: open the wire, ask, and mend what has gone wrong, again and again."""

import logging
from typing import TYPE_CHECKING

from robots import bus
from robots.drivers.contract import RobotState
from robots.drivers.errors import HardwareFault, RobotError
from robots.messages import Changed, Notice
from robots.models import Command, Grant, Robot
from robots.states import Cycle
from workers import ledger

if TYPE_CHECKING:
    from workers.runtime import Runtime

log = logging.getLogger(__name__)
AGAIN_S = 3.0


class Reach:
    """Whether the robot of `runtime` answers, and what is done until it does."""

    def __init__(self, runtime: "Runtime") -> None:
        self._runtime = runtime
        self.connected = False
        self._retry_at = 0.0

    def _ask(self) -> RobotState:
        """Open the wire and ask; what moves is held."""
        state = self._runtime.driver.connect()
        return self._runtime.driver.hold() if state.moving else state

    def connect(self, untouched: bool = False) -> None:
        """Reach the robot under a new epoch; what was not verified is not offered.

        `untouched`: it was ours all the time and at rest, so that one that was in order still is.
        """
        runtime = self._runtime
        try:
            state = self._ask()
            self.connected = True
        except RobotError as error:
            self._unready(str(error), incident=error.code)
            self.later(2.0)
            runtime.driver.close()
            return
        runtime.remember(state)
        cycle = Robot.objects.values_list("cycle", flat=True).get(pk=runtime.robot.pk)
        if untouched and state.ready and cycle in (Cycle.READY, Cycle.OFFERED):
            return
        if cycle in (Cycle.OFFLINE, Cycle.FAULT, Cycle.READY, Cycle.OFFERED):
            runtime.set_cycle(Cycle.HANDOVER, "", cycle)
        elif cycle == Cycle.OPERATING and not state.ready:
            self.faulted(HardwareFault("The controller lost its calibration."), None)

    def later(self, seconds: float) -> None:
        """Look after the robot again in `seconds` (s)."""
        self.connected = False
        self._retry_at = self._runtime.clock.monotonic() + seconds

    def faulted(self, error: HardwareFault, command: Command | None) -> None:
        """Soft reset after a hardware fault; what cannot be mended is a fault to wait out."""
        if self._runtime.executor.soft_reset(error, command):
            self.connected = True
            self._clear_reason()
            return
        self._unready(str(error))
        self.later(AGAIN_S)

    def lost_while_idle(self, error: HardwareFault) -> None:
        """Note that the hardware stopped answering while no command ran."""
        if self._runtime.running and not self._runtime.busy:
            log.warning("the robot: %s", error)
            self.later(0.0)
            self._unready(str(error), incident=error.code)

    def mend(self) -> None:
        """Try again to reach the robot and put it in order; quick to return before its time."""
        runtime = self._runtime
        if runtime.clock.monotonic() < self._retry_at:
            return
        self.later(AGAIN_S)
        runtime.driver.close()
        try:
            state = self._ask()
            grant = Grant.objects.filter(robot=runtime.robot, ended_at=None).first()
            if not state.ready and grant is not None:
                runtime.gate.open_for(grant, runtime.now())
                state = runtime.driver.recover(runtime.gate.bound(runtime.lease.epoch))
        except RobotError as error:
            runtime.driver.close()
            self._unready(str(error))
            return
        self.connected = True
        runtime.remember(state)
        self._clear_reason()
        runtime.set_cycle(Cycle.HANDOVER, "", Cycle.FAULT)
        bus.publish(runtime.robot.slug, Notice("The robot answers again. Look at the picture, then go on.", "info"))

    def _clear_reason(self) -> None:
        robot = self._runtime.robot
        Robot.objects.filter(pk=robot.pk).update(reason="")
        robot.reason = ""
        bus.publish(robot.slug, Changed("robot"))

    def _unready(self, text: str, incident: str = "") -> None:
        robot = self._runtime.robot
        if robot.reason != text and incident:
            ledger.incident(robot, incident, text, self._runtime.now(), remedy="Trying again every few seconds.")
        robot.reason = text[:300]
        told = Robot.objects.filter(pk=robot.pk)
        told.exclude(cycle__in=(Cycle.LOCKED_OUT, Cycle.OPERATING, Cycle.OFFERED)).update(cycle=Cycle.FAULT)
        told.update(reason=robot.reason)
        bus.publish(robot.slug, Changed("robot"))
