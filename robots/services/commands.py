"""Requests of one command: checked here first, and again by the owner and the driver."""

from contextlib import nullcontext, suppress
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from typing import Any

from django.db import IntegrityError, connection, transaction
from django.db.models import BigIntegerField, CharField, Count, Max, OuterRef, QuerySet, Subquery

from robots import bus
from robots.grants import end_grant, held_by, lease_of, open_grant, owner_alive, start_grant
from robots.kit.clock import SYSTEM, ms_of
from robots.kit.contract.errors import BadRequest, NotPermitted, RobotError, Stopped
from robots.kit.contract.find import spec_of
from robots.kit.contract.procedures import procedure
from robots.kit.contract.spec import TURN
from robots.kit.contract.values import check
from robots.models import Command, Grant, Lease, Robot
from robots.prepared import Prepared, Slot
from robots.services.clicks import resolve
from robots.services.permissions import need_level, need_staff
from robots.states import COMMAND_FINAL, GIVES_WAY_TO_STAFF, IN_ORDER, GrantEnd, GrantKind, Lane

START_S = 10.0  # a command that has not started within this time never starts
PENDING = 128
AHEAD_MS = 60_000  # the clock of a robot's host, which stamps its pictures, may be ahead by this
# the fields needed to check a command; few, because every click reads them
NEEDED = (
    "holder", "until", "opened_at", "kind", "robot__slug", "robot__driver", "robot__address", "robot__stop_latched",
    "robot__settings", "robot__lease__epoch", "robot__lease__expires_at", "robot__lease__state",
    "robot__lease__state_at",
)  # fmt: skip
SLUG, SEQ, GRANT = Slot("slug", CharField()), Slot("seq", BigIntegerField()), Slot("grant", BigIntegerField())
REFERENCES = {"program", "still"}  # values that name a row: a saved program, the picture of a click
LIMIT_S = 60.0  # of a kind of command that declares none
AFTER_S = 20.0  # after its limit a command and its grant end within this time
IS_PUT_IN_ORDER = "The robot is being put in order; try again when that is done."
USED = "This was not carried out: another page of yours has given a command at the same moment. Look, then try again."
OFF = "The robot is switched off. Switch it on first."
SILENT = "The robot's worker does not answer now. It is started again by itself; try again in some seconds."
STAFF_COMMAND_RUNS = "A command of staff runs on the robot; wait until it has ended."


def _counted(grants: QuerySet[Grant]) -> QuerySet[Grant]:
    """Annotate grants with `same` (their command of that number), `waiting` (commands not ended) and `last_end`."""
    theirs = Command.objects.filter(grant=OuterRef("pk")).order_by()
    unfinished = theirs.exclude(state__in=COMMAND_FINAL).values("grant").annotate(number=Count("pk"))
    ends = theirs.exclude(ended_at=None).values("grant").annotate(last=Max("ended_at"))
    return grants.annotate(
        same=Subquery(theirs.filter(client_seq=SEQ).values("pk")), waiting=Subquery(unfinished.values("number")),
        last_end=Subquery(ends.values("last")),
    )  # fmt: skip


_OPEN: Prepared[Grant] = Prepared(
    lambda: _counted(
        Grant.objects.select_related("robot__lease").filter(robot__slug=SLUG, ended_at=None).order_by().only(*NEEDED)
    )
)
_UNDER: Prepared[Grant] = Prepared(lambda: _counted(Grant.objects.filter(pk=GRANT).only("pk")))


class RobotOffline(NotPermitted):
    """The robot is off, or its worker does not answer."""

    code = "offline"


class NumberUsed(NotPermitted):
    """Another command has that sequence number under the grant."""

    code = "number_used"


@dataclass(frozen=True)
class Issued:
    """A command's row, and whether this call created it."""

    command: Command
    created: bool


def issue(
    slug: str, user: Any, kind: str, args: dict[str, Any], client_seq: int, now: datetime | None = None,
    seen_ms: int = 0,
) -> Issued:  # fmt: skip
    """Write one command under the user's open grant on the robot `slug` and wake its owner.

    The same command with the same sequence number returns the same row again. The owner and the driver repeat every
    check. `seen_ms`: when the picture that the person saw was taken (ms since 1970); 0 if that is not known.

    Raises:
        NumberUsed: another command has that sequence number.
        NotPermitted: no grant, grant over, stop latched, robot offline, too many waiting, clearance too low.
        BadRequest, OutOfWorkspace: the command itself is wrong.
    """
    now = now or SYSTEM.now()
    grant = held_by(_OPEN.first(slug=slug, seq=client_seq), user, now)
    if grant.kind == GrantKind.UPKEEP:
        raise NotPermitted(STAFF_COMMAND_RUNS)
    wanted = spec_of(grant.robot.driver).command(kind)
    if wanted is not None and not wanted.asked_by:
        raise NotPermitted(f"The command {kind} is given by the portal alone.")
    return _issue(grant, grant, user, kind, args, client_seq, now, picture_time(seen_ms, now))


def picture_time(ms: int, now: datetime) -> datetime | None:
    """Return when a picture was taken (`ms` since 1970); None for an impossible time."""
    return datetime.fromtimestamp(ms / 1000, UTC) if 0 < ms <= ms_of(now) + AHEAD_MS else None


def issue_under(grant: Grant, user: Any, kind: str, args: dict[str, Any], client_seq: int, now: datetime) -> Issued:
    """Write one command under a grant that is known to be open. Raises what `issue` raises."""
    (counted,) = _UNDER(grant=grant.pk, seq=client_seq)
    return _issue(grant, counted, user, kind, args, client_seq, now)


def _issue(
    grant: Grant, counted: Any, user: Any, kind: str, args: dict[str, Any], client_seq: int, now: datetime,
    seen: datetime | None = None,
) -> Issued:  # fmt: skip
    robot = grant.robot
    if counted.same is not None:
        return _same(Command.objects.get(pk=counted.same), robot, user, kind, args)
    if (counted.waiting or 0) >= PENDING:
        raise NotPermitted("Too many commands are waiting; let the robot catch up.")
    if not isinstance(args, dict):
        raise BadRequest("The values of a command must be an object.")
    spec = spec_of(robot.driver)
    found = spec.command(kind)
    by_staff = procedure(robot.driver, kind) if found is None else None
    wanted = found or by_staff
    _admit(robot, user, kind, wanted is not None and not wanted.open_to(TURN), now)
    if by_staff is None:
        if found is None or args.keys() & REFERENCES:
            kind, args = resolve(robot, user, kind, args)
        wanted = spec.command(kind)
        if wanted is not None and wanted.level > 1:
            need_level(user, robot, wanted)
        lease, since = getattr(robot, "lease", None), counted.last_end or grant.opened_at
        # where a command waits, the robot will have moved before this one begins
        state = None if lease is None or counted.waiting else lease.state_at_rest(spec, now, since)
        check(robot.driver, kind, args, robot.driver_settings(), state)
    limit_s = wanted.limit_s if wanted else LIMIT_S
    lane = wanted.lane if wanted else Lane.MOTION
    return _write(robot, user, grant, robot.lease.epoch, kind, args, client_seq, limit_s, now, lane, seen)


def _same(command: Command, robot: Robot, user: Any, kind: str, args: Any) -> Issued:
    """Return the row that has the number already, if it is this command. Raises NumberUsed."""
    if isinstance(args, dict) and (command.kind, command.args) != (kind, args):
        with suppress(RobotError):
            kind, args = resolve(robot, user, kind, args, again=True)
    if (command.kind, command.args) != (kind, args):
        raise NumberUsed(USED)
    return Issued(command, created=False)


def _admit(robot: Robot, user: Any, kind: str, staff_only: bool, now: datetime) -> None:
    if robot.stop_latched:
        raise Stopped("The robot is stopped. Look at the picture, then release the stop.")
    if not owner_alive(getattr(robot, "lease", None), now):
        raise RobotOffline(SILENT)
    if staff_only and not user.has_perm("robots.change_robot"):
        raise NotPermitted(f"The command {kind} is for staff.")


def _write(
    robot: Robot, user: Any, grant: Grant, epoch: int, kind: str, args: dict[str, Any],
    client_seq: int, limit_s: float, now: datetime, lane: str = Lane.MOTION,
    seen: datetime | None = None,
) -> Issued:  # fmt: skip
    # a single statement needs no transaction; inside an open one it needs a savepoint
    scope = transaction.atomic() if connection.in_atomic_block else nullcontext()
    try:
        with scope:
            command = Command.objects.create(
                robot=robot, grant=grant, client_seq=client_seq, issued_by=user, kind=kind, lane=lane, args=args,
                epoch=epoch, created_at=now, deadline=now + timedelta(seconds=START_S), limit_s=limit_s,
                seen_picture_at=seen,
            )  # fmt: skip
            transaction.on_commit(lambda: bus.wake_owner(robot.slug, epoch, lane), robust=True)
    except IntegrityError:
        return _same(Command.objects.get(grant=grant, client_seq=client_seq), robot, user, kind, args)
    return Issued(command, created=True)


def put(
    robot: Robot, grant: Grant, kind: str, args: dict[str, Any], limit_s: float, now: datetime, asker: Any = None,
    seen_at: datetime | None = None,
) -> Command:  # fmt: skip
    """Write the one command of a grant that this transaction opened for it; wake the owner after the transaction."""
    epoch = Lease.objects.values_list("epoch", flat=True).get(robot=robot)
    return _write(robot, asker, grant, epoch, kind, args, 1, limit_s, now, seen=seen_at).command


def over_by(now: datetime, limit_s: float) -> datetime:
    """Return when a grant ends that is opened `now` for one command, which may take `limit_s`."""
    return now + timedelta(seconds=START_S + limit_s + AFTER_S)


def next_seq(grant: Grant) -> int:
    """Return a sequence number greater than all that were used under the grant."""
    last = Command.objects.filter(grant=grant).aggregate(last=Max("client_seq"))["last"]
    return (last or 0) + 1


def need_worker(robot: Robot, now: datetime) -> None:
    """Check that a worker can carry out what staff ask. Raises RobotOffline: the robot is off, its worker silent."""
    if not robot.enabled:
        raise RobotOffline(OFF)
    if not owner_alive(lease_of(robot), now):
        raise RobotOffline(SILENT)


def staff_command(robot: Robot, user: Any, kind: str) -> Command:
    """Run one command of staff (a procedure of the robot) in their maintenance turn, or under a grant of its own.

    Its own grant ends with the command; until then the robot is offered to nobody. A refused command opens no grant.

    Raises:
        NotPermitted: not staff; somebody operates the robot, or it is in handover.
        Stopped, RobotOffline: as for every command.
    """
    need_staff(user)
    now = SYSTEM.now()
    with transaction.atomic():
        robot.refresh_from_db()
        need_worker(robot, now)
        grant = open_grant(robot)
        while grant is not None and grant.kind in GIVES_WAY_TO_STAFF:
            end_grant(grant, GrantEnd.PREEMPTED, "staff run a command", now)
            grant = open_grant(robot)
        if grant is None:
            wanted = procedure(robot.driver, kind)
            until = over_by(now, wanted.limit_s if wanted else LIMIT_S)
            grant = start_grant(robot, GrantKind.UPKEEP, now, user, until)
        elif grant.kind == GrantKind.UPKEEP:
            raise NotPermitted(STAFF_COMMAND_RUNS)
        elif grant.kind == GrantKind.JOB:
            raise NotPermitted("A job runs on the robot now; wait for its end, or cancel it on its page.")
        elif grant.kind in IN_ORDER:
            raise NotPermitted(IS_PUT_IN_ORDER)
        elif grant.holder_id != user.pk:
            raise NotPermitted("Somebody operates the robot now; lock it out first.")
        return issue_under(grant, user, kind, {}, next_seq(grant), now).command
