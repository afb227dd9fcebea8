"""Settings that commands change in parallel to motions, and how the changes of a turn or a job are restored.

The command rows hold what an operator changed; a setting is restored to staff's last value, or to the kind's default.
"""

from collections.abc import Iterable, Mapping
from datetime import datetime, timedelta
from typing import Any

from django.db import transaction
from django.db.models import F, Min, Q, QuerySet

from robots import bus
from robots.grants import COMES_TO_REST, open_grant, start_grant
from robots.kit.clock import SYSTEM
from robots.kit.contract.errors import BadRequest, NotPermitted
from robots.kit.contract.find import spec_of
from robots.kit.contract.spec import CommandKind
from robots.kit.contract.values import not_shown
from robots.models import Command, Grant, Robot
from robots.services.commands import IS_PUT_IN_ORDER, STAFF_COMMAND_RUNS, START_S, issue_under, need_worker, over_by
from robots.services.permissions import need_staff
from robots.states import COMMAND_RUNNING, IN_ORDER, CommandState, GrantKind, Lane

# commands of staff, under their own grant or another person's
BY_STAFF = Q(grant__kind__in=(GrantKind.UPKEEP, GrantKind.STAFF)) | ~Q(issued_by=F("grant__holder"))

NEVER_BEGUN = Q(state__in=(CommandState.REJECTED, CommandState.EXPIRED)) | Q(
    state=CommandState.CANCELLED, accepted_at=None
)


def settings_to_reset(
    robot: Robot, kinds: Iterable[CommandKind], grant: Grant | None = None, values: Mapping[str, float] | None = None
) -> list[tuple[CommandKind, Mapping[str, Any]]]:
    """Return (kind, arguments) of each setting that differs from staff's last value or from the default.

    A setting that was requested under the open `grant` stays, also while its command still waits. `values` are those of
    the robot's newest state. If they show that the robot has lost its last setting, as after a loss of power, or has
    one that nobody set, the setting is due under any grant.
    """
    found: list[tuple[CommandKind, Mapping[str, Any]]] = []
    for kind in kinds:
        if kind.lane != "config" or kind.default is None:
            continue
        asked = Command.objects.filter(robot=robot, lane=Lane.CONFIG, kind=kind.kind).exclude(NEVER_BEGUN)
        tried = asked.exclude(state=CommandState.QUEUED)
        theirs = tried.filter(BY_STAFF, issued_by__isnull=False)
        if not _is_forgotten(kind, tried, values or {}):
            if grant is not None and asked.filter(grant=grant, issued_by__isnull=False).exists():
                continue
            last = tried.first()
            if last is None or theirs.filter(pk=last.pk).exists():
                continue
            by_owner = last.issued_by_id is None and (last.client_seq < 0 or last.grant.kind != GrantKind.TURN)
            if by_owner and last.state == CommandState.COMPLETED:
                continue  # restored already
        kept = theirs.filter(state=CommandState.COMPLETED).first()
        found.append((kind, kept.args if kept else kind.default))
    return found


def _is_forgotten(kind: CommandKind, tried: QuerySet[Command], values: Mapping[str, float]) -> bool:
    """Return whether the robot shows another value than the last setting, or than the default if there is none."""
    if not all(channel in values for channel in kind.shown.values()):
        return False
    last = tried.first()
    if last is not None and last.state in COMMAND_RUNNING:
        return False
    done = tried.filter(state=CommandState.COMPLETED).first()
    return not_shown(kind, done.args if done else kind.default or {}, values) is not None


def reset_settings(
    robot: Robot, kinds: Iterable[CommandKind], grant: Grant, epoch: int, now: datetime,
    values: Mapping[str, float] | None = None,
) -> list[Command]:  # fmt: skip
    """Write the commands that set changed settings back, under an open grant; see `settings_to_reset`. Return them.

    Their numbers count downwards, so that the numbers of the holder's commands stay free. The owner runs them as any
    other command; the robot has confirmed a completed one.
    """
    rows = []
    for kind, args in settings_to_reset(robot, kinds, grant, values):
        row = Command.objects.create(
            robot=robot, grant=grant, client_seq=_number_below(grant), kind=kind.kind, lane=kind.lane, args=dict(args),
            epoch=epoch, created_at=now, deadline=now + timedelta(seconds=START_S), limit_s=kind.limit_s,
        )  # fmt: skip
        rows.append(row)
    if rows:
        transaction.on_commit(lambda: bus.wake_owner(robot.slug, epoch), robust=True)
    return rows


def configure(robot: Robot, user: Any, kind: str, args: dict[str, Any], now: datetime | None = None) -> Command:
    """Run one command of staff that changes a setting in parallel to a motion; the setting stays.

    It runs under the open grant of any holder, or under one of its own. Its number counts downwards, so that the
    numbers of the holder's commands stay free.

    Raises:
        NotPermitted: not staff; a command of staff runs, or the robot is in handover.
        BadRequest: no such setting, or wrong values.
        Stopped, RobotOffline: as for every command.
    """
    need_staff(user)
    now = now or SYSTEM.now()
    with transaction.atomic():
        robot.refresh_from_db()
        need_worker(robot, now)
        spec = spec_of(robot.driver).command(kind)
        if spec is None or spec.lane != "config":
            raise BadRequest(f"This robot has no setting called {kind}.")
        grant = open_grant(robot)
        if grant is None:
            grant = start_grant(robot, GrantKind.UPKEEP, now, user, over_by(now, spec.limit_s))
        elif grant.kind == GrantKind.UPKEEP:
            raise NotPermitted(STAFF_COMMAND_RUNS)
        elif grant.kind in IN_ORDER:
            raise NotPermitted(IS_PUT_IN_ORDER)
        elif grant.kind == GrantKind.REST:
            raise NotPermitted(COMES_TO_REST)
        return issue_under(grant, user, kind, args, _number_below(grant), now).command


def _number_below(grant: Grant) -> int:
    first = Command.objects.filter(grant=grant).aggregate(first=Min("client_seq"))["first"] or 0
    return min(first, 0) - 1
