"""Claims and runs the commands of one lane, one after another, and ends those that cannot run any more."""

from collections.abc import Callable
from datetime import datetime

from django.db.models import BigAutoField, BigIntegerField, CharField, DateTimeField, QuerySet

from robots import bus
from robots.grants import stage_event
from robots.models import Command, Robot
from robots.prepared import Prepared, PreparedUpdate, Slot
from robots.states import COMMAND_FINAL, COMMAND_RUNNING, CommandState
from workers.cameras.pictures import Pictures
from workers.commands.finish import finish
from workers.commands.packages import Packages, step_of
from workers.owned import OwnedRobot
from workers.safety.gate import TOO_LATE
from workers.safety.lane import Lane
from workers.safety.lease import OwnerLease

SWEEP_S = 1.0  # between two looks at the rows; a wake-up is answered at once
INTERRUPTED = (
    "The robot's worker was interrupted; whether this command was carried out is not known. "
    "Look at the new picture before you go on."
)
RESTARTED = "The robot's worker had to start again before this command began; it was not carried out."
BROKEN_OFF = "The database failed before this command began; it was not carried out."


ROBOT, ID = Slot("robot", BigAutoField()), Slot("id", BigAutoField())
PICTURE = Slot("picture", DateTimeField())
EPOCH, LANE, NOW = Slot("epoch", BigIntegerField()), Slot("lane", CharField()), Slot("now", DateTimeField())


def due(robot: Robot | Slot, epoch: int | Slot, lane: str | Slot) -> QuerySet[Command]:
    """Return the commands of a lane that wait for this owner, oldest first."""
    return Command.objects.filter(robot=robot, state=CommandState.QUEUED, epoch=epoch, lane=lane).order_by("id")


def unfinished(robot: Robot | Slot) -> QuerySet[Command]:
    """Return the commands that are not final, oldest first."""
    return Command.objects.filter(robot=robot).exclude(state__in=COMMAND_FINAL).order_by("id")


_UNFINISHED = Prepared(lambda: unfinished(ROBOT).select_related("grant"))
_CLAIM = PreparedUpdate(
    lambda: Command.objects.filter(pk=ID, state=CommandState.QUEUED, epoch=EPOCH, deadline__gt=NOW),
    state=CommandState.ACCEPTED, accepted_at=NOW, newest_picture_at=PICTURE,
)  # fmt: skip


def claim(command: Command, epoch: int, now: datetime, picture: datetime | None = None) -> bool:
    """Claim a command; `picture` is when the newest one was taken. Return False if it was claimed or is late."""
    done = _CLAIM(id=command.pk, epoch=epoch, now=now, picture=picture)
    if done:
        command.state, command.accepted_at = CommandState.ACCEPTED, now
        command.newest_picture_at = picture
        bus.publish(command.robot.slug, stage_event(command))
    return bool(done)


def tidy(robot: Robot, epoch: int, now: datetime, lane: str) -> int:
    """End commands of a lane that can no longer start or finish. Return how many.

    Called while no command runs in this lane. It ends commands that are too late, that were meant for an earlier
    owner, or whose claim the database carried out but did not confirm. The last were never started, because this
    owner starts only commands of which it knows that it claimed them.
    """
    ended = 0
    for command in unfinished(robot):
        command.robot = robot
        ours = command.epoch == epoch
        if command.state == CommandState.QUEUED and (not ours or command.deadline <= now):
            ended += finish(command, CommandState.EXPIRED, now, TOO_LATE if ours else RESTARTED)
        elif command.state in COMMAND_RUNNING and (not ours or command.lane == lane):
            state, reason = (CommandState.CANCELLED, BROKEN_OFF) if ours else (CommandState.UNKNOWN, INTERRUPTED)
            ended += finish(command, state, now, reason, at=step_of(command))
    return ended


def abandon(robot: Robot, now: datetime, packages: Packages | None = None) -> list[Command]:
    """End as `unknown` the commands that an earlier owner had started, with the step of a program. None is repeated."""
    left = list(Command.objects.filter(robot=robot, state__in=COMMAND_RUNNING))
    for command in left:
        command.robot = robot
        at = packages.left_at(command) if packages else step_of(command)
        finish(command, CommandState.UNKNOWN, now, INTERRUPTED, at=at)
        if packages:
            packages.end(command)
    return left


class Commands:
    """Claims and runs commands, one at a time, whichever thread asks."""

    def __init__(
        self, owned: OwnedRobot, lease: OwnerLease, lane: Lane, run: Callable[[Command], None], pictures: Pictures
    ) -> None:
        self._owned, self._lease, self.lane, self._run, self._pictures = owned, lease, lane, run, pictures
        self.before: Callable[[], bool] | None = None  # asked before anything runs: whether it may; None: it may

    def run_due(self) -> bool:
        """Run every command that waits. Return whether the robot had any command that was not final, of any lane."""
        if self.before is not None and not self.before():
            return True
        found = list(_UNFINISHED(robot=self._owned.robot.pk))
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
