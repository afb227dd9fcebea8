"""Claims the commands of one lane that wait, runs one after another, and gives each a final state."""

import contextlib
import logging
from collections.abc import Callable
from datetime import datetime
from typing import Any

from django.db import Error, close_old_connections

from robots.grants import has_own_grant
from robots.kit.contract.errors import (
    BadRequest,
    CameraFault,
    GaveUp,
    HardwareFault,
    MotionHeld,
    NotCalibrated,
    NotPermitted,
    OutOfWorkspace,
    RobotError,
    TooLate,
)
from robots.kit.contract.procedures import CALIBRATE, RESET, procedure
from robots.kit.contract.session import Moves, Observation, Permit, Progress, Report
from robots.kit.contract.spec import CommandKind
from robots.kit.contract.target import target_of
from robots.kit.contract.words import is_number
from robots.models import Command
from robots.states import CommandState
from workers.authority.lane import MOTION, Lane
from workers.commands import rows
from workers.commands.findings import Findings
from workers.commands.held import held_motion, replaceable
from workers.commands.packages import Packages
from workers.commands.paths import PathReporter
from workers.commands.progress import ProgressReporter
from workers.commands.readings import Readings
from workers.guard.deadman import DeadManTimer
from workers.media.pictures import Pictures
from workers.robot.calibration import calibrate_and_keep
from workers.robot.look import look
from workers.robot.owned import OwnedRobot

log = logging.getLogger(__name__)
LEASE_LOST = (
    "The robot's worker lost control of the robot for a moment and held it; "
    "whether this command was carried out is not known. Look at the new picture before you go on."
)
UNHEARD = "The robot did not acknowledge the command in time, so it was held."
NOT_HEARD = "The robot did not acknowledge the command in time; whether the setting was changed is not known."
NOT_KNOWN = "The database failed before the answer; whether the setting was changed is not known."
CUT_SHORT = "The database failed during the motion, so the robot was held. Look at the new picture before you go on."
BROKEN = "The robot's software failed, so the robot was held. Look at the new picture before you go on."
NOT_HELD = "The robot's software failed, and the robot could not be held. Look at it before you go on."
SWEEP_S = 1.0  # between two looks at the rows; a wake-up is answered at once
STAGES = {"sent": CommandState.SENT, "acknowledged": CommandState.ACKNOWLEDGED}


class Runner:
    """Runs one command at a time in the thread of its lane."""

    def __init__(
        self, owned: OwnedRobot, lane: Lane, deadman: DeadManTimer, pictures: Pictures, findings: Findings,
        packages: Packages, on_fault: Callable[[HardwareFault, Command], None], note_stop: Callable[[], None],
    ) -> None:  # fmt: skip
        self._owned, self._lease, self._lane = owned, lane.lease, lane
        self._deadman, self._pictures, self._on_fault, self._note_stop = deadman, pictures, on_fault, note_stop
        self._permit: Permit = lane.gate.check  # of the command that runs
        self._moves, self._progress, self._paths = lane.name == MOTION, ProgressReporter(owned), PathReporter(owned)
        self._readings, self._findings, self._packages = Readings(owned), findings, packages
        self._said = 0  # the last command that was sent to the robot, whatever the database says
        self._sent: tuple[int, datetime] | None = None  # a command, and when it was sent, which the database missed

    def run(self, command: Command) -> None:
        """Run a claimed command to a final state."""
        with self._lane.gate.command(command, self._owned.now()) as self._permit:
            if self._readings.wanted:
                self._readings.begin()
            self._lane.current = command  # not earlier: the watch must not judge it by the grant before
            try:
                self._run(command)
            finally:
                self._lane.current = None
        self._packages.end(command)

    def _run(self, command: Command) -> None:
        try:
            result = self._in_time(command)
        except (BadRequest, OutOfWorkspace, GaveUp) as error:
            refused = not isinstance(error, GaveUp)
            state = CommandState.REJECTED if refused else CommandState.FAILED
            self._end(command, state, str(error), {"code": error.code})
        except TooLate as error:
            self._end(command, CommandState.EXPIRED, str(error))
        except NotPermitted as error:
            begun = self._said == command.pk
            self._end(command, CommandState.CANCELLED if begun else CommandState.REJECTED, str(error))
        except (MotionHeld, CameraFault, NotCalibrated) as error:
            held = isinstance(error, MotionHeld)
            self._end(command, CommandState.CANCELLED if held else CommandState.FAILED, str(error))
        except HardwareFault as error:
            self._end(command, CommandState.FAILED, str(error))
            if not self._stale(command):  # otherwise the robot is connected again anyway
                self._on_fault(error, command)
        except Error as error:
            if self._said != command.pk:
                raise  # not started: the next sweep ends it
            log.warning("%s failed because of the database: %s", command, error)
            if self._moves:
                with contextlib.suppress(RobotError):
                    self._owned.driver.hold()
            self._end(command, CommandState.UNKNOWN, CUT_SHORT if self._moves else NOT_KNOWN)
        except Exception:
            self._hold_and_end(command)
            raise  # counted as a failure of this thread
        else:
            self._end(command, CommandState.COMPLETED, "", result)

    def _hold_and_end(self, command: Command) -> None:
        """Hold the robot and end a command that an error in our code or in the driver broke off."""
        reason = BROKEN
        try:
            self._owned.driver.hold()
        except Exception:
            log.exception("the robot could not be held")
            reason = NOT_HELD
        begun = self._said == command.pk
        self._end(command, CommandState.UNKNOWN if begun else CommandState.FAILED, reason)

    def _end(self, command: Command, state: CommandState, reason: str, result: dict[str, Any] | None = None) -> None:
        """Store the end of a command; while the database is away, try again for as long as the robot is ours."""
        at = self._owned.now()
        self._paths.end(command)
        if self._goes_on():
            log.warning("%s is ended by the next owner, which asks the robot first", command)
            return
        if self._moves and self._readings.wanted:
            result = {**(result or {}), **self._readings.end()}
        if left_out := self._findings.left_out(command):
            result = {**(result or {}), "left_out": left_out}
        if self._said == command.pk and self._stale(command):
            state, reason, result = CommandState.UNKNOWN, LEASE_LOST, None
        step = self._packages.left_at(command) if state != CommandState.COMPLETED else ""
        while True:
            try:
                self._note_stop()  # first: who sees the end asks whether it was a stop
                if self._sent is not None and self._sent[0] == command.pk:
                    rows.advance(command, CommandState.SENT, self._sent[1])
                rows.finish(command, state, at, reason, result, step)
            except Error as error:
                if not self._owned.running:
                    raise  # the next owner ends it as unknown
                log.warning("the end of %s waits for the database: %s", command, error)
                close_old_connections()
                self._owned.clock.sleep(0.2)
            else:
                break
        if has_own_grant(command):
            self._lane.gate.authority.grants.revoke(command.grant_id)  # the grant ended with the command

    def _goes_on(self) -> bool:
        """Return whether this owner ends while the motion may go on without it: the row says so to whoever follows."""
        owned = self._owned
        return self._moves and not owned.running and (owned.driver.rests_within() or 0.0) > 0.0

    def _stale(self, command: Command) -> bool:
        """Return whether the lease ran out after the command was claimed."""
        return not self._lease.valid or self._lease.epoch != command.epoch

    def _stage(self, command: Command, stage: Report) -> None:
        """Store a stage; if the database is away, a motion that has begun goes on."""
        if isinstance(stage, Progress):
            self._packages.reached(command, stage.text)
            self._progress.report(command, stage)
            return
        if isinstance(stage, Observation):
            self._findings.note(command, stage)
            return
        if isinstance(stage, Moves):
            self._paths.report(command, stage)
            return
        first, now = self._said != command.pk, self._owned.now()
        self._said = command.pk
        if stage == "acknowledged":
            self._lane.gate.note_begun()
        if first:  # not earlier: nothing that is only told delays the first byte
            command.target = _target(self._owned, command)
        try:
            rows.advance(command, STAGES[stage], now)
        except Error as error:
            if self._sent is None or self._sent[0] != command.pk:
                self._sent = command.pk, now
            log.warning("stage %s of %s is lost: %s", stage, command, error)
            close_old_connections()

    def _in_time(self, command: Command) -> dict[str, Any]:
        """Run the command. If the robot does not acknowledge it before the deadline, hold the robot.

        Raises the errors of drivers.
        """
        try:
            return self._perform(command)
        except TooLate as error:
            if self._said != command.pk:
                raise
            if not self._moves:
                raise HardwareFault(NOT_HEARD) from error
            self._owned.driver.hold()
            raise MotionHeld(UNHEARD) from error
        finally:
            self._lane.gate.note_begun()

    def _perform(self, command: Command) -> dict[str, Any]:
        owned, permit = self._owned, self._permit
        spec = owned.robot.spec().command(command.kind)
        if spec is None:
            by_staff = procedure(owned.robot.driver, command.kind)
            if by_staff is not None:
                return self._procedure(command, by_staff)
            raise BadRequest(f"This robot has no command called {command.kind}.")
        self._lane.gate.policies = spec.policies.by(owned.robot.spec().for_driver(owned.robot.settings))
        if spec.moves:
            self._pictures.still_id = 0

        def on_stage(stage: Report) -> None:
            self._stage(command, stage)

        why = package = ""
        if spec.held:
            outcome, why = held_motion(owned, self._deadman, command, permit, on_stage)
        else:
            if spec.replaceable:
                permit = replaceable(owned, self._lane, permit)
            package = self._packages.begin(command) if "text" in command.args else ""
            outcome = owned.driver.execute(command.kind, command.args, permit, on_stage)
        result: dict[str, Any] = {"sent": outcome.sent} | ({"ended": why} if why else {})
        result |= {"package": package} if package else {}
        if self._moves and spec.still_after and outcome.state is not None:
            result |= look(owned, self._pictures, outcome.state, command)
        return result

    def _procedure(self, command: Command, wanted: CommandKind) -> dict[str, Any]:
        owned, pictures, permit = self._owned, self._pictures, self._permit
        permit()
        self._lane.gate.note_begun()
        if wanted.moves:
            self._said = command.pk
            pictures.still_id = 0
        if wanted.kind == RESET:
            return look(owned, pictures, owned.driver.recover(permit), command)
        found = {"calibration": calibrate_and_keep(owned, pictures, permit)} if wanted.kind == CALIBRATE else {}
        return {**found, **look(owned, pictures, owned.driver.state(), command)}


def _target(owned: OwnedRobot, command: Command) -> dict[str, Any]:
    """Return where a command takes the robot from where it is."""
    known = owned.known_state()
    before = {name: value for name, value in known.values.items() if is_number(value)} if known else None
    return target_of(owned.robot.spec(), command.kind, command.args, before)


class Commands:
    """Claims and runs commands, one at a time, whichever thread asks."""

    def __init__(
        self, owned: OwnedRobot, lane: Lane, run: Callable[[Command], None], pictures: Pictures,
        before: Callable[[], bool] | None = None,
    ) -> None:  # fmt: skip
        self._owned, self._lease, self.lane, self._run, self._pictures = owned, lane.lease, lane, run, pictures
        self.before = before  # asked before anything runs: whether it may; None: it may

    def run_due(self) -> bool:
        """Run every command that waits. Return whether the robot had any command that was not final, of any lane."""
        if self.before is not None and not self.before():
            return True
        found = rows.unfinished_now(self._owned.robot)
        for command in found:
            if not self._owned.running:
                break
            ours = command.epoch == self._lease.epoch and command.lane == self.lane.name
            if ours and command.state == CommandState.QUEUED:
                self.run_one(command)
        return bool(found)

    def run_one(self, command: Command) -> None:
        """Claim a command and run it, unless another has claimed it or it is too late."""
        command.robot = self._owned.robot
        with self.lane.turn:
            if not rows.claim(command, self._lease.epoch, self._owned.now(), self._pictures.newest_at):
                return
            with self.lane.taking(command.limit_s + 10.0):
                self._run(command)

    def tidy(self) -> None:
        """End commands that can no longer start or finish."""
        with self.lane.turn:
            rows.tidy(self._owned.robot, self._lease.epoch, self._owned.now(), self.lane.name)

    def loop_config(self, connected: Callable[[], bool]) -> None:
        """Run the commands of the lane `config` until the owner ends; the other lane connects and hands over."""
        while self._owned.running:
            self.lane.sleep(SWEEP_S)
            if self.lane.pace.lively and self._lease.valid and connected():
                self.tidy()
                self.run_due()
