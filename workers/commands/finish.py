"""Advances a claimed command and ends it; each step is one conditional UPDATE."""

from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from datetime import datetime
from math import inf, isclose, isfinite
from typing import Any

from django.db import connection, transaction
from django.db.models import BigAutoField, CharField, DateTimeField, JSONField

from robots import bus
from robots.grants import end_with_command, has_own_grant, interruption, stage_event
from robots.models import Command
from robots.prepared import PreparedUpdate, Slot
from robots.states import COMMAND_FINAL, COMMAND_NEXT, CommandState

LONGEST = 300  # characters of a reason
NEAR = 1e-6  # of a number: a driver may round it
STAMPS = {
    CommandState.ACCEPTED: "accepted_at",
    CommandState.SENT: "sent_at",
    CommandState.ACKNOWLEDGED: "acknowledged_at",
}
ID, NOW, RESULT = Slot("id", BigAutoField()), Slot("now", DateTimeField()), Slot("result", JSONField())
CLAMPING = Slot("clamping", JSONField())
STATE, WAS, REASON = Slot("state", CharField()), Slot("was", CharField()), Slot("reason", CharField())
_ADVANCE = {
    state: PreparedUpdate(lambda: Command.objects.filter(pk=ID, state=WAS), **{"state": state, stamp: NOW})
    for state, stamp in STAMPS.items()
}
_FINISH = PreparedUpdate(
    lambda: Command.objects.filter(pk=ID).exclude(state__in=COMMAND_FINAL),
    state=STATE, reason=REASON, ended_at=NOW, result=RESULT, clamping=CLAMPING,
)  # fmt: skip


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
        done = _ADVANCE[state](id=command.pk, was=command.state, now=now)
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
