"""The rows of commands while their owner has them: claimed, advanced, ended; each step is one conditional UPDATE."""

from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from datetime import datetime
from math import inf, isclose, isfinite
from typing import Any

from django.db import connection, transaction
from django.db.models import BigAutoField, BigIntegerField, CharField, DateTimeField, JSONField, QuerySet

from robots import bus
from robots.grants import end_with_command, has_own_grant, interruption, stage_event
from robots.models import Command, Robot
from robots.prepared import Prepared, PreparedUpdate, Slot
from robots.states import COMMAND_FINAL, COMMAND_NEXT, COMMAND_RUNNING, CommandState
from workers.authority.gate import TOO_LATE
from workers.commands.packages import Packages, step_of

LONGEST = 300  # characters of a reason
NEAR = 1e-6  # of a number: a driver may round it
INTERRUPTED = (
    "The robot's worker was interrupted; whether this command was carried out is not known. "
    "Look at the new picture before you go on."
)
RESTARTED = "The robot's worker had to start again before this command began; it was not carried out."
BROKEN_OFF = "The database failed before this command began; it was not carried out."
STAMPS = {
    CommandState.ACCEPTED: "accepted_at",
    CommandState.SENT: "sent_at",
    CommandState.ACKNOWLEDGED: "acknowledged_at",
}
ROBOT, ID, NOW = Slot("robot", BigAutoField()), Slot("id", BigAutoField()), Slot("now", DateTimeField())
EPOCH, PICTURE = Slot("epoch", BigIntegerField()), Slot("picture", DateTimeField())
RESULT, CLAMPING, TARGET = (Slot(name, JSONField()) for name in ("result", "clamping", "target"))
STATE, WAS, REASON = Slot("state", CharField()), Slot("was", CharField()), Slot("reason", CharField())
_ADVANCE = {
    state: PreparedUpdate(
        lambda: Command.objects.filter(pk=ID, state=WAS), **{"state": state, stamp: NOW, "target": TARGET}
    )
    for state, stamp in STAMPS.items()
}
_FINISH = PreparedUpdate(
    lambda: Command.objects.filter(pk=ID).exclude(state__in=COMMAND_FINAL),
    state=STATE, reason=REASON, ended_at=NOW, result=RESULT, clamping=CLAMPING,
)  # fmt: skip


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


def unfinished_now(robot: Robot) -> list[Command]:
    """Return the commands that are not final with their grants, oldest first."""
    return _UNFINISHED(robot=robot.pk)


def claim(command: Command, epoch: int, now: datetime, picture: datetime | None = None) -> bool:
    """Claim a command; `picture` is when the newest one was taken. Return False if it was claimed or is late."""
    done = _CLAIM(id=command.pk, epoch=epoch, now=now, picture=picture)
    if done:
        command.state, command.accepted_at = CommandState.ACCEPTED, now
        command.newest_picture_at = picture
        bus.publish(command.robot.slug, stage_event(command))
    return bool(done)


@contextmanager
def without_waiting() -> Iterator[None]:
    """Commit what is inside without waiting for the disk, where that is SQLite's.

    The death of any process loses nothing by it. After a power failure the command may be as it was when it was
    claimed, so that it ends as unknown.
    """
    if connection.vendor != "sqlite" or connection.in_atomic_block:
        yield
        return
    with connection.cursor() as cursor:
        cursor.execute("PRAGMA synchronous=NORMAL")
        try:
            yield
        finally:
            cursor.execute("PRAGMA synchronous=FULL")


def advance(command: Command, state: CommandState, now: datetime) -> None:
    """Record that a claimed command reached a stage."""
    if state not in COMMAND_NEXT[command.state]:
        return
    stamp = STAMPS[state]
    with without_waiting():
        done = _ADVANCE[state](id=command.pk, was=command.state, now=now, target=command.target)
    if done:
        command.state = state
        setattr(command, stamp, now)
        bus.publish(command.robot.slug, stage_event(command))


def clamping_of(args: Any, sent: Any) -> dict[str, list[float]]:
    """Return by name the numbers that a command asked for and those that were sent in their place."""
    if not isinstance(args, dict) or not isinstance(sent, dict):
        return {}
    pairs = {name: [asked, sent[name]] for name, asked in args.items() if name in sent}
    return {name: pair for name, pair in pairs.items() if all(map(_finite, pair)) and not _alike(*pair)}


def storable(value: Any) -> Any:
    """Return a result without numbers that no database stores: None in their place."""
    if isinstance(value, dict):
        return {name: storable(one) for name, one in value.items()}
    if isinstance(value, list | tuple):
        return [storable(one) for one in value]
    return None if isinstance(value, float) and not isfinite(value) else value


def _alike(asked: float, sent: float) -> bool:
    return isclose(asked, sent, rel_tol=NEAR, abs_tol=NEAR * NEAR)


def _finite(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < inf


def _naming(reason: str, at: str) -> str:
    """Return a reason that names the step of a program, once: a driver may have done so."""
    named = f" It was at {at}." if at and at.partition(":")[0].lower() not in reason.lower() else ""
    return reason[: LONGEST - len(named)] + named


def finish(
    command: Command, state: CommandState, now: datetime, reason: str = "", result: dict[str, Any] | None = None,
    at: str = "",
) -> bool:  # fmt: skip
    """End a command, and its grant if that was opened for it alone. Return False if it had ended before.

    `at`: the step of a program at which it ended, in words.
    """
    alone, result = has_own_grant(command), storable(result or {})
    clamping = clamping_of(command.args, result.get("sent"))
    if alone and state == CommandState.CANCELLED:  # it knows that its grant is over, but not why
        reason = interruption(command.grant_id) or reason
    reason = _naming(reason, at)
    with without_waiting(), transaction.atomic() if alone else nullcontext():
        done = _FINISH(id=command.pk, state=state, reason=reason, now=now, result=result, clamping=clamping)
        if done:
            command.state, command.reason, command.ended_at = state, reason, now
            command.result, command.clamping = result, clamping
            if alone:
                end_with_command(command, now)
    if done:
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
