"""Which command rows wait for this owner, how one is claimed, and how others are ended."""

from datetime import datetime

from django.db.models import QuerySet

from robots import bus
from robots.grants import stage_event
from robots.models import Command, Robot
from robots.states import COMMAND_FINAL, COMMAND_RUNNING, CommandState
from workers.commands.finish import finish
from workers.safety.gate import TOO_LATE

INTERRUPTED = (
    "The robot's worker was interrupted; whether this command was carried out is not known. "
    "Look at the new picture before you go on."
)
RESTARTED = "The robot's worker had to start again before this command began; it was not carried out."
BROKEN_OFF = "The database failed before this command began; it was not carried out."


def due(robot: Robot, epoch: int, lane: str) -> QuerySet[Command]:
    """Return the commands of a lane that wait for this owner, oldest first."""
    return Command.objects.filter(robot=robot, state=CommandState.QUEUED, epoch=epoch, lane=lane).order_by("id")


def claim(command: Command, epoch: int, now: datetime) -> bool:
    """Claim a command. Return False if it was claimed already or is too late."""
    done = Command.objects.filter(pk=command.pk, state=CommandState.QUEUED, epoch=epoch, deadline__gt=now).update(
        state=CommandState.ACCEPTED, accepted_at=now
    )
    if done:
        command.state, command.accepted_at = CommandState.ACCEPTED, now
        bus.publish(command.robot.slug, stage_event(command))
    return bool(done)


def tidy(robot: Robot, epoch: int, now: datetime, lane: str) -> int:
    """End commands of a lane that can no longer start or finish. Return how many.

    Called while no command runs in this lane. It ends commands that are too late, that were meant for an earlier
    owner, or whose claim the database carried out but did not confirm. The last were never started, because this
    owner starts only commands of which it knows that it claimed them.
    """
    ended = 0
    for command in Command.objects.filter(robot=robot).exclude(state__in=COMMAND_FINAL).order_by("id"):
        command.robot = robot
        ours = command.epoch == epoch
        if command.state == CommandState.QUEUED and (not ours or command.deadline <= now):
            ended += finish(command, CommandState.EXPIRED, now, TOO_LATE if ours else RESTARTED)
        elif command.state in COMMAND_RUNNING and (not ours or command.lane == lane):
            state, reason = (CommandState.CANCELLED, BROKEN_OFF) if ours else (CommandState.UNKNOWN, INTERRUPTED)
            ended += finish(command, state, now, reason)
    return ended


def abandon(robot: Robot, now: datetime) -> list[Command]:
    """End as `unknown` the commands that an earlier owner had started. They are never repeated."""
    left = list(Command.objects.filter(robot=robot, state__in=COMMAND_RUNNING))
    for command in left:
        command.robot = robot
        finish(
            command,
            CommandState.UNKNOWN,
            now,
            INTERRUPTED,
        )
    return left
