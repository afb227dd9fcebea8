"""Claims and runs the commands of one lane, one after another."""

from robots.models import Command
from workers.commands import claim
from workers.commands.run import Runner
from workers.connection import Connection
from workers.owned import OwnedRobot
from workers.safety.lane import Lane
from workers.safety.lease import OwnerLease

SWEEP_S = 1.0  # between two looks at the rows; a wake-up is answered at once


class Commands:
    """Claims and runs commands, one at a time, whichever thread asks."""

    def __init__(self, owned: OwnedRobot, lease: OwnerLease, lane: Lane, runner: Runner) -> None:
        self._owned, self._lease, self.lane, self._runner = owned, lease, lane, runner

    def run_due(self) -> None:
        """Run every command that waits."""
        due = claim.due(self._owned.robot, self._lease.epoch, self.lane.name)
        for command in due.select_related("grant"):
            if not self._owned.running:
                return
            self.run_one(command)

    def run_one(self, command: Command) -> None:
        """Claim a command and run it, unless another has claimed it or it is too late."""
        command.robot = self._owned.robot
        with self.lane.turn:
            if not claim.claim(command, self._lease.epoch, self._owned.now()):
                return
            with self.lane.taking(command.limit_s + 10.0):
                self._runner.run(command)

    def tidy(self) -> None:
        """End commands that can no longer start or finish."""
        with self.lane.turn:
            claim.tidy(self._owned.robot, self._lease.epoch, self._owned.now(), self.lane.name)

    def loop_config(self, connection: Connection) -> None:
        """Run the commands of the lane `config` until the owner ends; the other lane connects and hands over."""
        while self._owned.running:
            self.lane.sleep(SWEEP_S)
            if self.lane.pace.lively and self._lease.valid and connection.connected:
                self.tidy()
                self.run_due()
