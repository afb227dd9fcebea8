"""The loop of the lane `motion`: it runs commands, and connects, tidies and hands over between them."""

import contextlib

from robots.kit.contract.errors import RobotError
from robots.states import Cycle
from workers.commands.findings import Findings
from workers.commands.run import Commands
from workers.media.pictures import Pictures
from workers.process.regain import Regain
from workers.robot.connection import Connection
from workers.robot.handover import Handover
from workers.robot.look import look
from workers.robot.owned import OwnedRobot

SWEEP_S, IDLE_SWEEP_S = 0.1, 1.0
LOOK_AGAIN_S = 3.0
AWAY_S, PAUSE_S = 30.0, 5.0


class Control:
    """Runs due commands; connects, tidies, hands over and takes pictures when none is due."""

    def __init__(
        self, owned: OwnedRobot, motion: Commands, beside: Commands, connection: Connection,
        regain: Regain, handover: Handover, pictures: Pictures, findings: Findings,
    ) -> None:  # fmt: skip
        self._owned, self._lease, self._motion, self._beside = owned, motion.lane.lease, motion, beside
        self._connection, self._regain, self._handover, self._pictures = connection, regain, handover, pictures
        self._findings, self._looked = findings, 0.0
        self.moves_until = 0.0  # a robot that was not asked yet may move until then, by an earlier owner's word

    def loop(self) -> None:
        """Run until the owner ends."""
        owned, lane, swept = self._owned, self._motion.lane, 0.0
        while owned.running:
            lane.sleep(SWEEP_S if lane.pace.lively else IDLE_SWEEP_S)
            if not self._lease.valid:
                self._regain.regain()
                continue
            unfinished = True
            if self._connection.connected:
                unfinished = self._motion.run_due()  # commands come before everything else
                if lane.beat - swept < SWEEP_S:
                    continue
            swept = lane.beat
            self._findings.register()
            if owned.refresh():
                with lane.taking(AWAY_S), self._beside.lane.paused(PAUSE_S):
                    owned.driver.close()
                    owned.renew_driver()
                self._connection.later(0.0)
            self._pictures.configure(owned.robot)
            if unfinished and (self._connection.connected or owned.clock.monotonic() >= self.moves_until):
                self._motion.tidy()
            if not self._connection.connected:
                with lane.taking(AWAY_S), self._beside.lane.paused(PAUSE_S):
                    self._connection.mend()
                self._motion.run_due()
            if self._connection.connected and owned.robot.cycle == Cycle.HANDOVER:
                with lane.taking(self._handover.longest_s):
                    self._handover.hand_over()
            self._look_if_unseen()

    def _look_if_unseen(self) -> None:
        """Take the picture of the robot at rest if a motion was cut short or the last picture failed."""
        owned, beat = self._owned, self._motion.lane.beat
        state = owned.driver.latest()
        resting = self._connection.connected and state is not None and not state.moving
        unseen = self._pictures.cameras and resting and self._pictures.still_id == 0
        if not unseen or owned.robot.cycle == Cycle.HANDOVER or beat - self._looked < LOOK_AGAIN_S:
            return
        self._looked = beat
        with self._motion.lane.taking(AWAY_S), contextlib.suppress(RobotError):
            look(owned, self._pictures, owned.driver.state(), None)
