"""Advances a claimed command and ends it; each step is one conditional UPDATE."""

from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from datetime import datetime
from typing import Any

from django.db import connection, transaction
from django.db.models import BigAutoField, CharField, DateTimeField, JSONField

from robots import bus
from robots.grants import end_with_command, has_own_grant, interruption, stage_event
from robots.models import Command
from robots.prepared import PreparedUpdate, Slot
from robots.states import COMMAND_FINAL, COMMAND_NEXT, CommandState

STAMPS = {
    CommandState.ACCEPTED: "accepted_at",
    CommandState.SENT: "sent_at",
    CommandState.ACKNOWLEDGED: "acknowledged_at",
}
ID, NOW, RESULT = Slot("id", BigAutoField()), Slot("now", DateTimeField()), Slot("result", JSONField())
STATE, WAS, REASON = Slot("state", CharField()), Slot("was", CharField()), Slot("reason", CharField())
_ADVANCE = {
    state: PreparedUpdate(lambda: Command.objects.filter(pk=ID, state=WAS), **{"state": state, stamp: NOW})
    for state, stamp in STAMPS.items()
}
_FINISH = PreparedUpdate(
    lambda: Command.objects.filter(pk=ID).exclude(state__in=COMMAND_FINAL),
    state=STATE, reason=REASON, ended_at=NOW, result=RESULT,
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


def finish(
    command: Command, state: CommandState, now: datetime, reason: str = "", result: dict[str, Any] | None = None
) -> bool:
    """End a command, and its grant if that was opened for it alone. Return False if it had ended before."""
    alone = has_own_grant(command)
    if alone and state == CommandState.CANCELLED:  # it knows that its grant is over, but not why
        reason = interruption(command.grant_id) or reason
    with without_waiting(), transaction.atomic() if alone else nullcontext():
        done = _FINISH(id=command.pk, state=state, reason=reason[:300], now=now, result=result or {})
        if done:
            command.state, command.reason, command.ended_at = state, reason[:300], now
            command.result = result or {}
            if alone:
                end_with_command(command, now)
    if done:
        bus.publish(command.robot.slug, stage_event(command))
    return bool(done)
