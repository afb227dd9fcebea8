"""The commands of one lane: which are due, claimed and run, one after another."""

from robots.models import Command
from workers.commands import claim
from workers.commands.run import Runner
from workers.connection import Connection
from workers.owned import OwnedRobot
from workers.safety.lane import Lane
from workers.safety.lease import OwnerLease

SWEEP_S = 1.0  # beside a motion; a wake-up is answered at once


class Commands:
    """Claims and runs commands; one at a time, whichever thread asks."""

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
        """Claim a command and carry it out, unless another has claimed it or it is too late."""
        command.robot = self._owned.robot
        with self.lane.turn:
            if not claim.claim(command, self._lease.epoch, self._owned.now()):
                return
            with self.lane.taking(command.limit_s + 10.0):
                self._runner.run(command)

    def tidy(self) -> None:
        """End what can no longer begin or end."""
        with self.lane.turn:
            claim.tidy(self._owned.robot, self._lease.epoch, self._owned.now(), self.lane.name)

    def loop_beside(self, connection: Connection) -> None:
        """Serve beside the motions, for as long as the owner runs; the other lane looks after the robot."""
        while self._owned.running:
            self.lane.sleep(SWEEP_S)
            if self.lane.pace.lively and self._lease.valid and connection.connected:
                self.tidy()
                self.run_due()
