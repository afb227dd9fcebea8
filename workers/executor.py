"""Carry out claimed commands on one robot, and mend what goes wrong on the way."""

import logging
from typing import TYPE_CHECKING, Any

from robots import bus
from robots.drivers.contract import RobotState
from robots.drivers.errors import (
    BadRequest,
    CameraFault,
    HardwareFault,
    Held,
    NotPermitted,
    OutOfWorkspace,
    RobotError,
)
from robots.messages import Notice
from robots.models import Command
from robots.services import RUNTIME_KINDS
from robots.states import CommandState
from robots.vision.calibration import NotCalibrated
from workers import ledger
from workers.calibrate import calibrate

if TYPE_CHECKING:
    from workers.runtime import Runtime

log = logging.getLogger(__name__)
STAGES = {"sent": CommandState.SENT, "acknowledged": CommandState.ACKNOWLEDGED}


class Executor:
    """Runs one command at a time in the control loop of `runtime`."""

    def __init__(self, runtime: "Runtime") -> None:
        self._runtime = runtime

    def run(self, command: Command) -> None:
        """Execute a claimed command to a final state."""
        runtime = self._runtime
        runtime.gate.open_for(command.grant, runtime.now())
        if command.grant.ended_at is not None:
            runtime.gate.revoke(command.grant_id)
        try:
            result = self._perform(command)
        except (BadRequest, OutOfWorkspace) as error:
            self._end(command, CommandState.REJECTED, str(error))
        except NotPermitted as error:
            begun = command.sent_at is not None
            self._end(command, CommandState.CANCELLED if begun else CommandState.REJECTED, str(error))
        except (Held, CameraFault, NotCalibrated) as error:
            held = isinstance(error, Held)
            self._end(command, CommandState.CANCELLED if held else CommandState.FAILED, str(error))
        except HardwareFault as error:
            self._end(command, CommandState.FAILED, str(error))
            runtime.faulted(error, command)
        else:
            self._end(command, CommandState.COMPLETED, "", result)

    def _end(self, command: Command, state: CommandState, reason: str, result: dict[str, Any] | None = None) -> None:
        ledger.finish(command, state, self._runtime.now(), reason, result)

    def _perform(self, command: Command) -> dict[str, Any]:
        runtime = self._runtime
        if command.kind in RUNTIME_KINDS:
            return self._runtime_kind(command)
        spec = runtime.driver.features.command(command.kind)
        if spec is None:
            raise BadRequest(f"This robot has no command called {command.kind}.")
        if spec.moves:
            runtime.pictures.still_id = 0
        outcome = runtime.driver.execute(
            command.kind,
            command.args,
            runtime.gate.check,
            lambda stage: ledger.advance(command, STAGES[stage], runtime.now()),
        )
        result: dict[str, Any] = {"sent": outcome.sent}
        if spec.still and outcome.state is not None:
            result |= self.look(outcome.state, command)
        return result

    def look(self, state: RobotState, command: Command | None) -> dict[str, Any]:
        """Take the new stable picture; a camera that fails does not undo the motion."""
        runtime = self._runtime
        runtime.remember(state)
        try:
            grant = command.grant if command else None
            frame, verdict = runtime.pictures.still(state, grant, command)
        except CameraFault as error:
            return {"picture": None, "verdict": "no picture", "note": str(error)}
        result: dict[str, Any] = {
            "verdict": verdict.reason,
            "stable": verdict.stable,
            "tries": verdict.tries,
            "difference": round(verdict.difference, 2),
        }
        if frame is None:
            result["note"] = "The picture could not be kept: the disk may be full."
        else:
            result |= {"picture": frame.url, "still": frame.pk}
        return result

    def _runtime_kind(self, command: Command) -> dict[str, Any]:
        runtime = self._runtime
        runtime.gate.check()
        match command.kind:
            case "soft_reset":
                runtime.pictures.still_id = 0
                state = runtime.driver.recover(runtime.gate.check)
                return self.look(state, command)
            case "calibrate":
                runtime.pictures.still_id = 0
                found = calibrate(runtime.driver, runtime.pictures.settle, runtime.gate.check)
                runtime.keep_calibration(found)
                return {"calibration": found, **self.look(runtime.driver.state(), command)}
            case _:
                return self.look(runtime.driver.state(), command)

    def soft_reset(self, cause: HardwareFault, command: Command | None) -> bool:
        """Reset after a fault, keep the incident, tell the operator; True if it worked."""
        runtime = self._runtime
        slug = runtime.robot.slug
        incident = ledger.incident(runtime.robot, cause.code, str(cause), runtime.now(), command)
        try:
            runtime.gate.check()
        except NotPermitted as error:
            incident.remedy = f"No soft reset: {error}"[:300]
            incident.save(update_fields=["remedy"])
            return False
        bus.publish(slug, Notice(f"{cause} The controller is being reset.", "warning"))
        try:
            runtime.pictures.still_id = 0
            state = runtime.driver.recover(runtime.gate.check)
        except RobotError as error:
            incident.remedy = f"The soft reset failed: {error}"[:300]
            incident.save(update_fields=["remedy"])
            bus.publish(slug, Notice(f"The soft reset failed: {error}", "error"))
            return False
        incident.remedy = "Soft reset: controller reset, recalibrated, back at the previous position."
        incident.save(update_fields=["remedy"])
        self.look(state, command)
        bus.publish(slug, Notice("The robot was reset and is back where it was. Look, then go on.", "info"))
        return True
