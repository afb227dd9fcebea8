"""Settings that commands change beside motions, and how a turn's or a job's changes are set back.

The command rows tell what an operator changed; it is set back to what staff set last, or to the kind's default.
"""

from collections.abc import Iterable, Mapping
from datetime import datetime, timedelta
from typing import Any

from django.db import transaction
from django.db.models import F, Max, Min, Q

from robots import bus
from robots.clock import SYSTEM
from robots.contract.find import spec_of
from robots.contract.spec import CommandKind
from robots.drivers.errors import BadRequest, NotPermitted
from robots.grants import open_grant, start_grant
from robots.models import Command, Grant, Robot
from robots.permissions import need_staff
from robots.services.commands import AFTER_S, IN_ORDER, ONE_COMMAND, START_S, issue_under
from robots.states import CommandState, GrantKind, Lane

# by staff: under their own grant or another person's
BY_STAFF = Q(grant__kind__in=(GrantKind.UPKEEP, GrantKind.STAFF)) | ~Q(issued_by=F("grant__holder"))


def to_restore(robot: Robot, kinds: Iterable[CommandKind]) -> list[tuple[CommandKind, Mapping[str, Any]]]:
    """Return (kind, arguments) of each setting that differs from what staff set or from the default."""
    found: list[tuple[CommandKind, Mapping[str, Any]]] = []
    for kind in kinds:
        if kind.lane != "config" or kind.default is None:
            continue
        tried = Command.objects.filter(robot=robot, lane=Lane.CONFIG, kind=kind.kind).exclude(
            Q(state__in=(CommandState.QUEUED, CommandState.REJECTED, CommandState.EXPIRED))
            | Q(state=CommandState.CANCELLED, accepted_at=None)
        )
        theirs = tried.filter(BY_STAFF, issued_by__isnull=False)
        last = tried.first()
        if last is None or theirs.filter(pk=last.pk).exists():
            continue
        if last.issued_by_id is None and last.grant.kind != GrantKind.TURN and last.state == CommandState.COMPLETED:
            continue  # set back already
        kept = theirs.filter(state=CommandState.COMPLETED).first()
        found.append((kind, kept.args if kept else kind.default))
    return found


def restore(robot: Robot, kinds: Iterable[CommandKind], grant: Grant, epoch: int, now: datetime) -> list[Command]:
    """Write the commands that set back changed settings, under an open grant. Return them.

    The owner runs them as any other command; a completed one is confirmed by the robot.
    """
    rows = []
    for kind, args in to_restore(robot, kinds):
        last = Command.objects.filter(grant=grant).aggregate(last=Max("client_seq"))["last"] or 0
        row = Command.objects.create(
            robot=robot, grant=grant, client_seq=last + 1, kind=kind.kind, lane=kind.lane, args=dict(args),
            epoch=epoch, created_at=now, deadline=now + timedelta(seconds=START_S), limit_s=kind.limit_s,
        )  # fmt: skip
        rows.append(row)
    if rows:
        transaction.on_commit(lambda: bus.wake_owner(robot.slug, epoch), robust=True)
    return rows


def configure(robot: Robot, user: Any, kind: str, args: dict[str, Any], now: datetime | None = None) -> Command:
    """Run one command of staff that changes a setting beside whatever the robot does; the setting stays.

    It runs under the open grant, whoever holds it, or under one of its own. It is numbered downwards, so that the
    numbers of the holder's commands are not used.

    Raises:
        NotPermitted: not staff; a command of staff runs, or the robot is in handover.
        BadRequest: no such setting, or wrong values.
        Stopped, RobotOffline: as for every command.
    """
    need_staff(user)
    now = now or SYSTEM.now()
    with transaction.atomic():
        robot.refresh_from_db()
        spec = spec_of(robot.driver).command(kind)
        if spec is None or spec.lane != "config":
            raise BadRequest(f"This robot has no setting called {kind}.")
        grant = open_grant(robot)
        if grant is None:
            seconds = START_S + spec.limit_s + AFTER_S
            grant = start_grant(robot, GrantKind.UPKEEP, now, user, now + timedelta(seconds=seconds))
        elif grant.kind == GrantKind.UPKEEP:
            raise NotPermitted(ONE_COMMAND)
        elif grant.kind == GrantKind.HANDOVER:
            raise NotPermitted(IN_ORDER)
        first = Command.objects.filter(grant=grant).aggregate(first=Min("client_seq"))["first"] or 0
        return issue_under(grant, user, kind, args, min(first, 0) - 1, now).command
