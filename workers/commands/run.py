"""Carry out claimed commands in one lane, each to a final state."""

import contextlib
import logging
from typing import Any

from django.db import Error, close_old_connections

from robots.contract.session import Permit
from robots.drivers.errors import (
    BadRequest,
    CameraFault,
    HardwareFault,
    Held,
    NotPermitted,
    OutOfWorkspace,
    RobotError,
    TooLate,
)
from robots.drivers.mercury.calibration import NotCalibrated
from robots.models import Command
from robots.services.commands import RUNTIME_KINDS
from robots.states import ONE_COMMAND, CommandState
from workers.calibrate import calibrate_and_keep
from workers.cameras.look import look
from workers.cameras.pictures import Pictures
from workers.commands import finish
from workers.commands.motion import held_motion, replaceable
from workers.connection import Connection
from workers.owned import OwnedRobot
from workers.safety.deadman import DeadManTimer
from workers.safety.lane import Lane
from workers.safety.lease import OwnerLease

log = logging.getLogger(__name__)
LEASE_LOST = (
    "The robot's worker lost the robot for a moment and held it; what became of this command is not known. "
    "Look at the new picture before you go on."
)
UNHEARD = "The robot did not say in time whether it had understood, so it was held."
CUT_SHORT = "The database broke off in mid-motion, so the robot was held. Look at the new picture before you go on."
BROKEN = "The robot's software failed, so the robot was held. Look at the new picture before you go on."
MOVING_KINDS = ("soft_reset", "calibrate")
STAGES = {"sent": CommandState.SENT, "acknowledged": CommandState.ACKNOWLEDGED}


class Runner:
    """Runs one command at a time in the thread of its lane."""

    def __init__(
        self, owned: OwnedRobot, lease: OwnerLease, lane: Lane, deadman: DeadManTimer,
        pictures: Pictures, connection: Connection,
    ) -> None:  # fmt: skip
        self._owned, self._lease, self._lane = owned, lease, lane
        self._deadman, self._pictures, self._connection = deadman, pictures, connection
        self._permit: Permit = lane.gate.check  # of the claim that is carried out
        self._said = 0  # the command that the robot was told of last, whatever the database knows of it

    def run(self, command: Command) -> None:
        """Execute a claimed command to a final state."""
        gate, now = self._lane.gate, self._owned.now
        gate.open_for(command.grant, now())
        gate.expect(command, now())
        self._permit = gate.bound(command.epoch)
        if command.grant.ended_at is not None:
            gate.revoke(command.grant_id)
        self._lane.current = command  # only now: who watches must not hold it by the grant before
        try:
            self._run(command)
        finally:
            self._lane.current = None

    def _run(self, command: Command) -> None:
        try:
            result = self._in_time(command)
        except (BadRequest, OutOfWorkspace) as error:
            self._end(command, CommandState.REJECTED, str(error))
        except TooLate as error:
            self._end(command, CommandState.EXPIRED, str(error))
        except NotPermitted as error:
            begun = self._said == command.pk
            self._end(command, CommandState.CANCELLED if begun else CommandState.REJECTED, str(error))
        except (Held, CameraFault, NotCalibrated) as error:
            held = isinstance(error, Held)
            self._end(command, CommandState.CANCELLED if held else CommandState.FAILED, str(error))
        except HardwareFault as error:
            self._end(command, CommandState.FAILED, str(error))
            if not self._stale(command):  # then the robot is connected anew anyway
                self._connection.faulted(error, command)
        except Error as error:
            if self._said != command.pk:
                raise  # not begun: the next sweep ends it
            log.warning("%s is held, for the database broke off: %s", command, error)
            with contextlib.suppress(RobotError):
                self._owned.driver.hold()
            self._end(command, CommandState.UNKNOWN, CUT_SHORT)
        except Exception:
            self._hold_and_end(command)
            raise  # counted as a failure of this thread
        else:
            self._end(command, CommandState.COMPLETED, "", result)

    def _hold_and_end(self, command: Command) -> None:
        """End what an error of our own or of the driver's program broke off."""
        with contextlib.suppress(RobotError):
            self._owned.driver.hold()
        begun = self._said == command.pk
        self._end(command, CommandState.UNKNOWN if begun else CommandState.FAILED, BROKEN)

    def _end(self, command: Command, state: CommandState, reason: str, result: dict[str, Any] | None = None) -> None:
        """Write the end down; a database that is away is waited for, for as long as the robot is ours."""
        at = self._owned.now()
        if self._said == command.pk and self._stale(command):
            state, reason, result = CommandState.UNKNOWN, LEASE_LOST, None
        while True:
            try:
                finish.finish(command, state, at, reason, result)
            except Error as error:
                if not self._owned.running:
                    raise  # the next owner ends it as unknown
                log.warning("the end of %s waits for the database: %s", command, error)
                close_old_connections()
                self._owned.clock.sleep(0.2)
            else:
                break
        if command.grant.kind in ONE_COMMAND:
            self._lane.gate.revoke(command.grant_id)  # it ended with the command, so nothing moves under it

    def _stale(self, command: Command) -> bool:
        """Tell whether the lease ran out after the command was claimed."""
        return not self._lease.valid or self._lease.epoch != command.epoch

    def _stage(self, command: Command, stage: str) -> None:
        """Write a stage down; a motion that has begun is not broken off by a database that is away."""
        self._said = command.pk
        if stage == "acknowledged":
            self._lane.gate.begun()
        try:
            finish.advance(command, STAGES[stage], self._owned.now())
        except Error as error:
            log.warning("stage %s of %s is lost: %s", stage, command, error)
            close_old_connections()

    def _in_time(self, command: Command) -> dict[str, Any]:
        """Perform; what was said and not heard to be understood by its deadline is held. Raises as drivers do."""
        try:
            return self._perform(command)
        except TooLate as error:
            if self._said != command.pk:
                raise
            self._owned.driver.hold()
            raise Held(UNHEARD) from error
        finally:
            self._lane.gate.begun()

    def _perform(self, command: Command) -> dict[str, Any]:
        if command.kind in RUNTIME_KINDS:
            return self._runtime_kind(command)
        owned, permit = self._owned, self._permit
        spec = owned.robot.spec().command(command.kind)
        if spec is None:
            raise BadRequest(f"This robot has no command called {command.kind}.")
        if spec.moves:
            self._pictures.still_id = 0

        def on_stage(stage: str) -> None:
            self._stage(command, stage)

        why = ""
        if spec.held:
            outcome, why = held_motion(owned, self._deadman, command, permit, on_stage)
        else:
            if spec.replaceable:
                permit = replaceable(owned, self._lease, self._lane, permit)
            outcome = owned.driver.execute(command.kind, command.args, permit, on_stage)
        result: dict[str, Any] = {"sent": outcome.sent} | ({"ended": why} if why else {})
        if spec.still_after and outcome.state is not None:
            result |= look(owned, self._pictures, outcome.state, command)
        return result

    def _runtime_kind(self, command: Command) -> dict[str, Any]:
        owned, pictures, permit = self._owned, self._pictures, self._permit
        permit()
        self._lane.gate.begun()
        if command.kind in MOVING_KINDS:
            self._said = command.pk
            pictures.still_id = 0
        match command.kind:
            case "soft_reset":
                return look(owned, pictures, owned.driver.recover(permit), command)
            case "calibrate":
                found = calibrate_and_keep(owned, pictures, permit)
                return {"calibration": found, **look(owned, pictures, owned.driver.state(), command)}
            case _:
                return look(owned, pictures, owned.driver.state(), command)
