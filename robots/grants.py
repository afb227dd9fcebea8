"""Grants, the permissions to move a robot, from opening to end; and the epoch of the robot's owner."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import datetime, timedelta
from typing import Any

from django.db import IntegrityError, transaction
from django.db.models import BigAutoField, CharField, DateTimeField, F, QuerySet

from robots import bus
from robots.kit.contract.errors import GrantOver, NotPermitted, StaleEpoch
from robots.kit.contract.procedures import PICTURE
from robots.kit.packets import Changed, CommandStage
from robots.models import Command, Grant, Lease, Robot
from robots.people import is_person
from robots.prepared import Prepared, PreparedUpdate, Slot
from robots.states import COMMAND_FINAL, COMMAND_RUNNING, ONE_COMMAND, CommandState, Cycle, GrantEnd, GrantKind, Lane

END_CODES = {
    CommandState.COMPLETED: GrantEnd.FINISHED, CommandState.CANCELLED: GrantEnd.STOPPED,
    CommandState.UNKNOWN: GrantEnd.OWNER_LOST, CommandState.EXPIRED: GrantEnd.OWNER_LOST,
}  # fmt: skip
INTERRUPTED = "Interrupted"  # so begins the reason of what gave way to somebody else


DIGITS = 6  # decimals of a number that pages are told: 1 µm and 0.06 thousandths of a degree
COMES_TO_REST = "The robot comes to rest after what it did before; try again in a moment."


class AnotherGrant(NotPermitted):
    """A grant is open on the robot, which may have only one."""


def owner_alive(lease: Lease | None, now: datetime) -> bool:
    """Return whether the robot's worker renewed its lease lately."""
    return bool(lease and lease.expires_at and lease.expires_at > now)


ROBOT, GRANT, NOW = Slot("robot", BigAutoField()), Slot("grant", BigAutoField()), Slot("now", DateTimeField())
_LEASE: Prepared[Lease] = Prepared(lambda: Lease.objects.filter(robot=ROBOT))
_OPEN: Prepared[Grant] = Prepared(lambda: Grant.objects.filter(robot=ROBOT, ended_at=None).order_by("pk")[:1])
_SINGLE: Prepared[Grant] = Prepared(
    lambda: Grant.objects.filter(robot=ROBOT, kind__in=(*ONE_COMMAND, GrantKind.REST), ended_at=None).order_by("pk")[:1]
)
_QUEUED: Prepared[Command] = Prepared(lambda: _queued().select_related("grant"))
_QUEUED_UNDER: Prepared[Command] = Prepared(lambda: _queued().filter(grant=GRANT).select_related("grant"))
_CANCELLED = {"state": CommandState.CANCELLED, "reason": Slot("reason", CharField()), "ended_at": NOW}
_CANCEL: PreparedUpdate[Command] = PreparedUpdate(lambda: _queued(), **_CANCELLED)
_CANCEL_UNDER: PreparedUpdate[Command] = PreparedUpdate(lambda: _queued().filter(grant=GRANT), **_CANCELLED)
_MOVES: Prepared[Grant] = Prepared(lambda: _that_move().order_by("-pk")[:1])


def _queued() -> QuerySet[Command]:
    return Command.objects.filter(robot=ROBOT, state=CommandState.QUEUED)


def _that_move() -> QuerySet[Grant]:
    found = Grant.objects.filter(robot=ROBOT).exclude(kind=GrantKind.UPKEEP, holder__isnull=False)
    return found.exclude(kind__in=(GrantKind.SETTINGS, GrantKind.REST))


def lease_of(robot: Robot) -> Lease | None:
    """Return which process owns the robot; None if none ever did."""
    return _LEASE.first(robot=robot.pk)


def open_grant(robot: Robot) -> Grant | None:
    """Return the robot's open grant."""
    return _OPEN.first(robot=robot.pk)


def newest_grant(robot: Robot) -> Grant | None:
    """Return the grant of the robot that was opened last, ended or not."""
    return Grant.objects.filter(robot=robot).order_by("-pk").first()


def newest_grant_that_moves(robot: Robot) -> Grant | None:
    """Return the grant that was opened last, but for what moves nothing and hands nothing over.

    Single commands of staff, as for a picture, settings that were set back after a stop, and coming to rest.
    """
    return _MOVES.first(robot=robot.pk)


def grant_of(robot: Robot, user: Any, now: datetime) -> Grant:
    """Return the user's open grant on the robot. Raises GrantOver."""
    return held_by(open_grant(robot), user, now)


def held_by(grant: Grant | None, user: Any, now: datetime) -> Grant:
    """Return the grant if it belongs to the user and is open. Raises GrantOver."""
    if grant is None or not is_person(user, grant.holder_id):
        raise GrantOver("It is not your turn on this robot.")
    if grant.until and grant.until <= now:
        raise GrantOver("Your turn on this robot is over.")
    return grant


def start_grant(
    robot: Robot, kind: GrantKind, now: datetime, holder: Any = None, until: datetime | None = None
) -> Grant:
    """Open a grant. Raises AnotherGrant if one is open."""
    lease = lease_of(robot)
    try:
        with transaction.atomic():
            return Grant.objects.create(
                robot=robot, kind=kind, holder=holder, opened_at=now, until=until, epoch=lease.epoch if lease else 0
            )
    except IntegrityError as error:
        rests = Grant.objects.filter(robot=robot, kind=GrantKind.REST, ended_at=None).exists()
        raise AnotherGrant(COMES_TO_REST if rests else "Somebody else may move the robot now.") from error


@contextmanager
def granted(robot: Robot, kind: GrantKind, now: Callable[[], datetime], seconds: float) -> Iterator[Grant]:
    """Open a grant for the body of a `with` statement, for at most `seconds`; it ends with the body.

    Raises:
        AnotherGrant: a grant is open.
    """
    grant = start_grant(robot, kind, now(), until=now() + timedelta(seconds=seconds))
    try:
        yield grant
    except StaleEpoch:
        end_grant(grant, GrantEnd.OWNER_LOST, "the owner's lease ran out", now())
        raise
    except Exception:
        end_grant(grant, GrantEnd.FAILED, "could not be verified", now())
        raise
    else:
        end_grant(grant, GrantEnd.FINISHED, "in order", now())


def end_grant(grant: Grant, code: GrantEnd, reason: str, now: datetime) -> bool:
    """Close a grant and cancel the commands that wait under it. Return False if it was closed before.

    No other function ends a grant. `code` is for software, `reason` for people. Where the robot may go on without a
    word, a grant of its own follows, until it rests.
    """
    end = {"end_code": code, "end_reason": reason[:120]}
    with transaction.atomic():
        done = Grant.objects.filter(pk=grant.pk, ended_at=None).update(ended_at=now, **end)
        if done:
            told = interruption(grant.pk) or reason if grant.kind in ONE_COMMAND else f"the turn ended: {reason}"
            cancel_queued(grant.robot, told, now, grant=grant)
            _let_rest(grant, now)
            bus.publish_on_commit(grant.robot.slug, Changed("robot"))
    return bool(done)


def _let_rest(grant: Grant, now: datetime) -> None:
    """Open a grant until the robot rests, if what runs under the ended one may go on without a word."""
    seconds = goes_on_for(grant.robot, None) if grant.kind != GrantKind.REST else None
    if seconds is not None:
        start_grant(grant.robot, GrantKind.REST, now, until=now + timedelta(seconds=seconds))


def goes_on_for(robot: Robot, settings: dict[str, Any] | None) -> float | None:
    """Return for how many seconds more what runs may go on without a word, and come to rest; None: nothing may.

    `settings`: as of `Spec.rests_within`.
    """
    within = rests_within(robot, settings)
    return within if within is not None and within > (robot.spec().rest_s or 0.0) else None


def running_motions(robot: Robot) -> list[str]:
    """Return the kinds of the motions that run by the rows."""
    running = Command.objects.filter(robot=robot, lane=Lane.MOTION, state__in=COMMAND_RUNNING)
    return list(running.values_list("kind", flat=True))


def rests_within(robot: Robot, settings: dict[str, Any] | None) -> float | None:
    """Return within how many seconds the robot rests that nobody has asked yet, and no word reaches; None: not known.

    By the rows a motion may run that was allowed to go on by itself. Until the robot was asked, it counts as moving.
    `settings`: as of `Spec.rests_within`.
    """
    try:
        spec = robot.spec()
    except LookupError:
        return None
    kinds = [*running_motions(robot), ""]
    return None if spec.rest_s is None else max(spec.rests_within(kind, settings) or 0.0 for kind in kinds)


def interruption(grant: int) -> str:
    """Return in a sentence that somebody else came first, which is no fault; empty where the grant has not ended so."""
    given_way = Grant.objects.filter(pk=grant, end_code=GrantEnd.PREEMPTED)
    reason = given_way.values_list("end_reason", flat=True).first()
    return f"{INTERRUPTED}, because {reason}." if reason else ""


def has_own_grant(command: Command) -> bool:
    """Return whether the grant was opened for this command alone."""
    kind = command.grant.kind
    return kind in ONE_COMMAND and (command.lane != Lane.CONFIG or kind == GrantKind.UPKEEP)


def end_with_command(command: Command, now: datetime) -> bool:
    """End the grant that was opened for this one command, which has ended. Return False if there is none."""
    if not has_own_grant(command):
        return False
    grant = Grant.objects.filter(pk=command.grant_id, kind__in=ONE_COMMAND, ended_at=None).first()
    if grant is None:
        return False
    code = END_CODES.get(CommandState(command.state), GrantEnd.FAILED)
    rests = command.kind == PICTURE.kind or command.lane == Lane.CONFIG
    return _end_single(grant, code, f"{command.kind}: {command.state}", now, rests)


def end_overdue_single(robot: Robot, now: datetime) -> None:
    """End grants for one command, or for coming to rest, whose owner died and was not replaced."""
    grant = _SINGLE.first(robot=robot.pk)
    if grant is None:
        return
    ended = grant.kind != GrantKind.REST and not grant.commands.exclude(state__in=COMMAND_FINAL).exists()
    if ended or (grant.until is not None and grant.until <= now):
        _end_single(grant, GrantEnd.TIME_UP, "time is up", now)


def end_grants_of(holder: Any, reason: str, now: datetime) -> None:
    """End what a person may move, whose account is deleted: a grant that nobody holds is the robot's own."""
    for grant in Grant.objects.filter(holder=holder, ended_at=None):
        _end_single(grant, GrantEnd.UNFIT, reason, now)


def _end_single(grant: Grant, code: GrantEnd, reason: str, now: datetime, rests: bool = False) -> bool:
    """End it; a robot that staff may have moved is handed over before it is offered."""
    if not end_grant(grant, code, reason, now):
        return False
    if grant.kind == GrantKind.UPKEEP and grant.holder_id is not None and not rests:
        found = Robot.objects.filter(pk=grant.robot_id, cycle__in=(Cycle.READY, Cycle.OFFERED))
        found.update(cycle=Cycle.HANDOVER)
    return True


def cancel_queued(robot: Robot, reason: str, now: datetime, grant: Grant | None = None) -> int:
    """Cancel every command that has not started."""
    read, cancel = (_QUEUED, _CANCEL) if grant is None else (_QUEUED_UNDER, _CANCEL_UNDER)
    which = {"robot": robot.pk, "grant": grant.pk if grant is not None else 0}
    found = read(**which)
    # one statement for all, so that none can start meanwhile; after a stop a hundred may wait
    if not cancel(**which, reason=reason, now=now):
        return 0
    ended = Command.objects.filter(pk__in=[c.pk for c in found], state=CommandState.CANCELLED, ended_at=now)
    cancelled = set(ended.values_list("pk", flat=True))
    for command in found:
        if command.pk in cancelled:
            command.state, command.reason, command.ended_at = CommandState.CANCELLED, reason, now
            bus.publish_on_commit(robot.slug, stage_event(command))
            if grant is None:
                end_with_command(command, now)
    return len(cancelled)


def told_result(command: Command) -> dict[str, Any]:
    """Return the result of a command for everybody: what was sent without texts, which its author alone may know."""
    told: dict[str, Any] = command.result
    return {**told, "sent": rounded_without_texts(told["sent"])} if "sent" in told else told


def told_target(command: Command) -> dict[str, Any]:
    """Return where a running command takes the robot (see `target_of`); empty once it has ended."""
    return {} if command.final else command.target


def rounded_without_texts(value: Any) -> Any:
    """Return a JSON value without texts, its numbers rounded to `DIGITS` decimals."""
    if isinstance(value, dict):
        return {name: rounded_without_texts(one) for name, one in value.items() if not isinstance(one, str)}
    if isinstance(value, list):
        return [rounded_without_texts(one) for one in value if not isinstance(one, str)]
    return round(value, DIGITS) if isinstance(value, float) else value


def stage_event(command: Command) -> CommandStage:
    """Return the event that tells a command's stage."""
    return CommandStage(
        id=command.pk, seq=command.client_seq, grant=command.grant_id, kind=command.kind,
        state=command.state, reason=command.reason, at_ms=int(command.reached_at.timestamp() * 1000),
        result=told_result(command), progress=command.progress, target=told_target(command),
    )  # fmt: skip


def take_epoch(lease: Lease, now: datetime, seconds: float, host: str, pid: int, started: str) -> int | None:
    """Raise the epoch and take the lease. Return None if another process was faster."""
    done = Lease.objects.filter(pk=lease.pk, epoch=lease.epoch).update(
        epoch=F("epoch") + 1, expires_at=now + timedelta(seconds=seconds), host=host, pid=pid, started=started
    )
    return lease.epoch + 1 if done else None
