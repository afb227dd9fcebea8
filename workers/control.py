"""The loop of the lane `motion`: it runs what is due, and looks after the robot in between."""

import contextlib

from robots.drivers.errors import RobotError
from robots.models import Command
from robots.states import Cycle
from workers.cameras.look import look
from workers.cameras.pictures import Pictures
from workers.commands import claim
from workers.commands.run import Runner
from workers.connection import Connection
from workers.handover import Handover
from workers.owned import OwnedRobot
from workers.regain import Regain
from workers.safety.lane import Lane
from workers.safety.lease import OwnerLease

SWEEP_S, IDLE_SWEEP_S = 0.1, 1.0
LOOK_AGAIN_S = 3.0


class Control:
    """Claims and runs commands; connects, tidies, hands over and looks when none is due."""

    def __init__(
        self, owned: OwnedRobot, lease: OwnerLease, lane: Lane, runner: Runner, connection: Connection,
        regain: Regain, handover: Handover, pictures: Pictures,
    ) -> None:  # fmt: skip
        self._owned, self._lease, self._lane, self._runner = owned, lease, lane, runner
        self._connection, self._regain, self._handover, self._pictures = connection, regain, handover, pictures
        self._looked = 0.0

    def loop(self) -> None:
        """Serve for as long as the owner runs."""
        owned, lane, swept = self._owned, self._lane, 0.0
        while owned.running:
            lane.sleep(SWEEP_S if lane.pace.lively else IDLE_SWEEP_S)
            if not self._lease.valid:
                self._regain.regain()
                continue
            if self._connection.connected:
                self._run_due()  # answer the wake-up before anything else
                if lane.beat - swept < SWEEP_S:
                    continue
            swept = lane.beat
            if owned.refresh():
                self._connection.later(0.0)
            self._pictures.configure(owned.robot)
            claim.tidy(owned.robot, self._lease.epoch, owned.now())
            if not self._connection.connected:
                with lane.taking(30.0):
                    self._connection.mend()
            self._run_due()
            if self._connection.connected and owned.robot.cycle == Cycle.HANDOVER:
                with lane.taking(180.0):
                    self._handover.hand_over()
            self._look_if_unseen()

    def _look_if_unseen(self) -> None:
        """Where a motion was cut short or a picture failed, take the picture of where the robot rests."""
        owned, beat = self._owned, self._lane.beat
        state = owned.driver.latest()
        resting = self._connection.connected and state is not None and not state.moving
        unseen = self._pictures.cameras and resting and self._pictures.still_id == 0
        if not unseen or owned.robot.cycle == Cycle.HANDOVER or beat - self._looked < LOOK_AGAIN_S:
            return
        self._looked = beat
        with self._lane.taking(30.0), contextlib.suppress(RobotError):
            look(owned, self._pictures, owned.driver.state(), None)

    def _run_due(self) -> None:
        for command in claim.due(self._owned.robot, self._lease.epoch).select_related("grant"):
            if not self._owned.running:
                return
            self.run_one(command)

    def run_one(self, command: Command) -> None:
        """Claim a command and carry it out, unless another has claimed it or it is too late."""
        command.robot = self._owned.robot
        if not claim.claim(command, self._lease.epoch, self._owned.now()):
            return
        with self._lane.taking(command.limit_s + 10.0):
            self._runner.run(command)
