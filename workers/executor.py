"""Carry out claimed commands on one robot, and mend what goes wrong on the way."""

import contextlib
import logging
from typing import TYPE_CHECKING, Any

from django.db import Error, close_old_connections

from robots import bus
from robots.drivers.contract import Outcome, Permit, RobotState
from robots.drivers.errors import (
    BadRequest,
    CameraFault,
    HandGone,
    HardwareFault,
    Held,
    NotPermitted,
    OutOfWorkspace,
    Replaced,
    RobotError,
    TooLate,
)
from robots.messages import Notice
from robots.models import Command
from robots.services import RUNTIME_KINDS
from robots.states import CommandState, GrantKind
from robots.vision.calibration import NotCalibrated
from workers import ledger
from workers.calibrate import calibrate

if TYPE_CHECKING:
    from workers.runtime import Runtime

log = logging.getLogger(__name__)
LEASE_LOST = (
    "The robot's worker lost the robot for a moment and held it; what became of this command is not known. "
    "Look at the new picture before you go on."
)
UNHEARD = "The robot did not say in time whether it had understood, so it was held."
CUT_SHORT = "The database broke off in mid-motion, so the robot was held. Look at the new picture before you go on."
MOVING_KINDS = ("soft_reset", "calibrate")
STAGES = {"sent": CommandState.SENT, "acknowledged": CommandState.ACKNOWLEDGED}


class Executor:
    """Runs one command at a time in the control loop of `runtime`."""

    def __init__(self, runtime: "Runtime") -> None:
        self._runtime = runtime
        self._permit: Permit = runtime.gate.check  # of the claim that is carried out
        self._said = 0  # the command that the robot was told of last, whatever the database knows of it

    def run(self, command: Command) -> None:
        """Execute a claimed command to a final state."""
        runtime = self._runtime
        runtime.gate.open_for(command.grant, runtime.now())
        runtime.gate.expect(command, runtime.now())
        self._permit = runtime.gate.bound(command.epoch)
        if command.grant.ended_at is not None:
            runtime.gate.revoke(command.grant_id)
        runtime.current = command  # only now: who watches must not hold it by the grant before
        try:
            self._run(command)
        finally:
            runtime.current = None

    def _run(self, command: Command) -> None:
        runtime = self._runtime
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
            if not self._stale(command):  # then the robot is reached anew anyway
                runtime.reach.faulted(error, command)
        except Error as error:
            if self._said != command.pk:
                raise  # not begun: the next sweep ends it
            log.warning("%s is held, for the database broke off: %s", command, error)
            with contextlib.suppress(RobotError):
                runtime.driver.hold()
            self._end(command, CommandState.UNKNOWN, CUT_SHORT)
        else:
            self._end(command, CommandState.COMPLETED, "", result)

    def _end(self, command: Command, state: CommandState, reason: str, result: dict[str, Any] | None = None) -> None:
        """Write the end down; a database that is away is waited for, for as long as the robot is ours."""
        at = self._runtime.now()
        if self._said == command.pk and self._stale(command):
            state, reason, result = CommandState.UNKNOWN, LEASE_LOST, None
        while True:
            try:
                ledger.finish(command, state, at, reason, result)
            except Error as error:
                if not self._runtime.running:
                    raise  # the next owner ends it as unknown
                log.warning("the end of %s waits for the database: %s", command, error)
                close_old_connections()
                self._runtime.clock.sleep(0.2)
            else:
                break
        if command.grant.kind == GrantKind.UPKEEP:
            self._runtime.gate.revoke(command.grant_id)  # it ended with the command, so nothing moves under it

    def _stale(self, command: Command) -> bool:
        """Tell whether the lease ran out after the command was claimed."""
        lease = self._runtime.lease
        return not lease.valid or lease.epoch != command.epoch

    def _stage(self, command: Command, stage: str) -> None:
        """Write a stage down; a motion that has begun is not broken off by a database that is away."""
        self._said = command.pk
        if stage == "acknowledged":
            self._runtime.gate.begun()
        try:
            ledger.advance(command, STAGES[stage], self._runtime.now())
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
            self._runtime.driver.hold()
            raise Held(UNHEARD) from error
        finally:
            self._runtime.gate.begun()

    def _perform(self, command: Command) -> dict[str, Any]:
        runtime = self._runtime
        if command.kind in RUNTIME_KINDS:
            return self._runtime_kind(command)
        spec = runtime.driver.features.command(command.kind)
        if spec is None:
            raise BadRequest(f"This robot has no command called {command.kind}.")
        if spec.moves:
            runtime.pictures.still_id = 0
        if spec.held:
            outcome, why = self._held_motion(command)
        else:
            permit = self._replaceable(command) if spec.replaceable else self._permit
            outcome = runtime.driver.execute(
                command.kind, command.args, permit, lambda stage: self._stage(command, stage)
            )
            why = ""
        result: dict[str, Any] = {"sent": outcome.sent} | ({"ended": why} if why else {})
        if spec.still and outcome.state is not None:
            result |= self.look(outcome.state, command)
        return result

    def _replaceable(self, command: Command) -> Permit:
        """Return a permit that ends when a newer target waits; the bell says when to look for one."""
        runtime = self._runtime
        kinds = [c.kind for c in runtime.driver.features.commands if c.replaceable]
        looked, claimed = runtime.rung, self._permit

        def permit() -> None:
            nonlocal looked
            claimed()
            if runtime.rung == looked or not runtime.gate.has_begun:
                return  # before it has begun the line may be ours, and a hold must not wait for the stores
            looked = runtime.rung
            try:
                first = ledger.due(runtime.robot, runtime.lease.epoch).first()
            except Error as error:
                log.warning("a newer target cannot be read, so this motion goes on: %s", error)
                close_old_connections()
                return
            if first is not None and first.kind in kinds:
                raise Replaced("Replaced: a newer target took its place.")

        return permit

    def _held_motion(self, command: Command) -> tuple[Outcome, str]:
        """Run a held motion until its hand is gone; that is its good end unless the hand was lost."""
        runtime, hand, claimed = self._runtime, self._runtime.hand, self._permit

        def permit() -> None:
            claimed()
            hand.check()

        hand.take(command)
        try:
            outcome = runtime.driver.execute(
                command.kind, command.args, permit, lambda stage: self._stage(command, stage)
            )
            return outcome, "edge"
        except (HandGone, Held):
            claimed()  # a stop, a lost grant: that is the reason then
            why = hand.gone
            if why in ("", "lost"):
                raise Held("Nothing was heard from your controls, so the arm was held.") from None
            return Outcome({}, runtime.driver.state()), why
        finally:
            hand.end()

    def look(self, state: RobotState, command: Command | None) -> dict[str, Any]:
        """Take the new stable picture; a camera that fails does not undo the motion."""
        runtime = self._runtime
        try:
            runtime.remember(state)
            if not runtime.pictures.eyes:
                return {"verdict": "no camera"}
            grant = command.grant if command else None
            frame, verdict = runtime.pictures.still(state, grant, command)
        except CameraFault as error:
            return {"picture": None, "verdict": "no picture", "note": str(error)}
        except Error as error:
            log.warning("a picture is lost: %s", error)
            close_old_connections()
            return {"picture": None, "verdict": "no picture", "note": "The database did not take the picture."}
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
        permit = self._permit
        permit()
        runtime.gate.begun()
        if command.kind in MOVING_KINDS:
            self._said = command.pk
        match command.kind:
            case "soft_reset":
                runtime.pictures.still_id = 0
                state = runtime.driver.recover(permit)
                return self.look(state, command)
            case "calibrate":
                runtime.pictures.still_id = 0
                found = calibrate(runtime.driver, runtime.pictures.settle, permit)
                runtime.keep_calibration(found)
                return {"calibration": found, **self.look(runtime.driver.state(), command)}
            case _:
                return self.look(runtime.driver.state(), command)

    def soft_reset(self, cause: HardwareFault, command: Command | None) -> bool:
        """Reset after a fault, keep the incident, tell the operator; True if it worked."""
        runtime = self._runtime
        slug = runtime.robot.slug
        incident = ledger.incident(runtime.robot, cause.code, str(cause), runtime.now(), command)
        permit = runtime.gate.bound(command.epoch if command else runtime.lease.epoch)
        try:
            permit()
        except NotPermitted as error:
            incident.remedy = f"No soft reset: {error}"[:300]
            incident.save(update_fields=["remedy"])
            return False
        bus.publish(slug, Notice(f"{cause} The controller is being reset.", "warning"))
        try:
            runtime.pictures.still_id = 0
            state = runtime.driver.recover(permit)
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
