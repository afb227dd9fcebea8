"""Runs the commands of one lane that wait, one after another."""

from collections.abc import Callable

from robots.models import Command
from robots.states import CommandState
from workers.authority.lane import Lane
from workers.commands.rows import claim, tidy, unfinished_now
from workers.media.pictures import Pictures
from workers.robot.owned import OwnedRobot

SWEEP_S = 1.0  # between two looks at the rows; a wake-up is answered at once


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
        found = unfinished_now(self._owned.robot)
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
            if not claim(command, self._lease.epoch, self._owned.now(), self._pictures.newest_at):
                return
            with self.lane.taking(command.limit_s + 10.0):
                self._run(command)

    def tidy(self) -> None:
        """End commands that can no longer start or finish."""
        with self.lane.turn:
            tidy(self._owned.robot, self._lease.epoch, self._owned.now(), self.lane.name)

    def loop_config(self, connected: Callable[[], bool]) -> None:
        """Run the commands of the lane `config` until the owner ends; the other lane connects and hands over."""
        while self._owned.running:
            self.lane.sleep(SWEEP_S)
            if self.lane.pace.lively and self._lease.valid and connected():
                self.tidy()
                self.run_due()
