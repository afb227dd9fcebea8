"""What may be asked of a robot, by whom: one verb, one function.

Pages, sockets, admin and tasks call these; permission, transaction, row and event live
here. Services write rows, only the owner advances them.
"""

from contextlib import nullcontext
from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import Any

from django.db import IntegrityError, connection, transaction
from django.db.models import F, Max, Q

from robots import bus, programs
from robots.clock import SYSTEM
from robots.drivers.contract import make_driver
from robots.drivers.errors import BadRequest, NotPermitted, Stopped
from robots.drivers.mercury import calibration
from robots.grants import cancel_queued, end_grant, held, open_grant, owner_alive, start_grant
from robots.messages import Changed
from robots.models import Command, Frame, Grant, Incident, Robot
from robots.permissions import need_staff
from robots.states import COMMAND_FINAL, Cycle, GrantKind

START_S = 10.0  # a command that has not begun by then never will
PENDING = 128
OWNER_ALIVE_S = 5.0
# what is read to judge a command: one small row, for it is on the way of every click
NEEDED = (
    "holder", "until", "kind", "robot__slug", "robot__driver", "robot__address", "robot__stop_latched",
    "robot__speed", "robot__boxes", "robot__lease__epoch", "robot__lease__expires_at",
)  # fmt: skip
RUNTIME_KINDS = frozenset({"soft_reset", "calibrate", "still"})
AFTER_S = 20.0  # after its limit a command is final, and its grant with it
NOT_THEIRS = "Only the operator and staff can stop this robot."
ONE_COMMAND = "A command of staff runs on the robot; wait for its end."


class RobotOffline(NotPermitted):
    """No worker owns the robot now."""

    code = "offline"


@dataclass(frozen=True)
class Issued:
    """A command's row, and whether this call made it."""

    command: Command
    created: bool


def newest_still(robot: Robot) -> Frame | None:
    """Return the newest kept picture."""
    return Frame.objects.filter(robot=robot).order_by("-id").first()


def resolve(robot: Robot, user: Any, kind: str, args: dict[str, Any]) -> tuple[str, dict[str, Any]]:
    """Turn a click in a picture into a move, by the calibration of that picture; a saved program into its text.

    Raises:
        BadRequest: no such picture, a point outside it, an old picture, no calibration.

    """
    if kind == "program" and "program" in args:
        return kind, {"text": programs.one(robot, user, _integer(args, "program")).text}
    if kind != "click":
        return kind, args
    frame = Frame.objects.filter(robot=robot, pk=_integer(args, "still")).first()
    if frame is None:
        raise BadRequest("That picture is unknown; wait for the next one and click there.")
    newest = newest_still(robot)
    if newest is None or newest.pk != frame.pk:
        raise BadRequest("The arm has moved since that picture; click in the newest one.")
    u, v = _real(args, "u"), _real(args, "v")
    if not (0 <= u <= frame.width - 1 and 0 <= v <= frame.height - 1):
        raise BadRequest("That point lies outside the picture.")
    try:
        x, y = calibration.target(frame.calibration, tuple(frame.pose), u, v, frame.width, frame.height)
    except calibration.NotCalibrated as error:
        raise BadRequest(str(error)) from error
    return "move", {"x": x, "y": y}


def _integer(args: dict[str, Any], name: str) -> int:
    value = args.get(name)
    if isinstance(value, bool) or not isinstance(value, int) or abs(value) >= 2**63:
        raise BadRequest(f"The value {name} must be a whole number.")
    return value


def _real(args: dict[str, Any], name: str) -> float:
    value = args.get(name)
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < 1e9:
        raise BadRequest(f"The value {name} must be a number.")
    return float(value)


def issue(
    slug: str, user: Any, kind: str, args: dict[str, Any], client_seq: int, now: datetime | None = None
) -> Issued:
    """Write one command under the user's open grant on the robot `slug` and ring its owner.

    The same sequence number again returns the same row. Every check here is done again by
    the owner and the driver.

    Raises:
        NotPermitted: no grant, grant over, stop latched, robot offline, too many waiting.
        BadRequest, OutOfWorkspace: the command itself is wrong.

    """
    now = now or SYSTEM.now()
    found = Grant.objects.select_related("robot__lease").filter(robot__slug=slug, ended_at=None)
    grant = held(found.order_by().only(*NEEDED).first(), user, now)
    if grant.kind == GrantKind.UPKEEP:
        raise NotPermitted(ONE_COMMAND)
    return _issue(grant, user, kind, args, client_seq, now)


def _issue(grant: Grant, user: Any, kind: str, args: dict[str, Any], client_seq: int, now: datetime) -> Issued:
    robot = grant.robot
    unfinished = ~Q(state__in=COMMAND_FINAL)
    rows = list(Command.objects.filter(unfinished | Q(client_seq=client_seq), grant=grant)[: PENDING + 1])
    for row in rows:
        if row.client_seq == client_seq:
            return Issued(row, created=False)
    if len(rows) >= PENDING:
        raise NotPermitted("Too many commands are waiting; let the robot catch up.")
    if not isinstance(args, dict):
        raise BadRequest("The values of a command must be an object.")
    driver = make_driver(robot.driver, robot.address, robot.driver_settings())
    spec = driver.features.command(kind)
    _admit(robot, user, kind, staff_only=kind in RUNTIME_KINDS or (spec is not None and spec.level >= 9), now=now)
    if kind in RUNTIME_KINDS:
        limit_s = _limit_s(kind)
    else:
        kind, args = resolve(robot, user, kind, args)
        driver.check(kind, args)
        spec = driver.features.command(kind)
        limit_s = spec.limit_s if spec else 60.0
    return _write(robot, user, grant, robot.lease.epoch, kind, args, client_seq, limit_s, now)


def _limit_s(kind: str) -> float:
    return 180.0 if kind == "calibrate" else 60.0


def _admit(robot: Robot, user: Any, kind: str, staff_only: bool, now: datetime) -> None:
    if robot.stop_latched:
        raise Stopped("The robot is stopped. Look at the picture, then release the stop.")
    if not owner_alive(getattr(robot, "lease", None), now):
        raise RobotOffline("The robot's worker does not answer now; your place is kept.")
    if staff_only and not user.has_perm("robots.change_robot"):
        raise NotPermitted(f"The command {kind} is for keepers of the robot.")


def _write(
    robot: Robot, user: Any, grant: Grant, epoch: int, kind: str, args: dict[str, Any],
    client_seq: int, limit_s: float, now: datetime,
) -> Issued:  # fmt: skip
    # one statement needs no transaction of its own; inside somebody's it needs a savepoint
    scope = transaction.atomic() if connection.in_atomic_block else nullcontext()
    try:
        with scope:
            command = Command.objects.create(
                robot=robot, grant=grant, client_seq=client_seq, issued_by=user, kind=kind, args=args,
                epoch=epoch, created_at=now, deadline=now + timedelta(seconds=START_S), limit_s=limit_s,
            )  # fmt: skip
            transaction.on_commit(lambda: bus.ring(robot.slug, epoch), robust=True)
    except IntegrityError:
        return Issued(Command.objects.get(grant=grant, client_seq=client_seq), created=False)
    return Issued(command, created=True)


def next_seq(grant: Grant) -> int:
    """Return a sequence number after all that were used under the grant."""
    last = Command.objects.filter(grant=grant).aggregate(last=Max("client_seq"))["last"]
    return (last or 0) + 1


def may_stop(robot: Robot, user: Any) -> bool:
    """Tell whether this person is offered the stop: the holder of the grant, and staff."""
    return _stops_under(robot, user) is not None


def _stops_under(robot: Robot, user: Any) -> int | None:
    """Return the grant under which this person stops the robot; 0 for staff, None for who may not."""
    if user is None or not user.is_authenticated:
        return None
    if user.has_perm("robots.change_robot"):
        return 0
    grant = open_grant(robot)
    return grant.pk if grant is not None and grant.holder_id == user.pk else None


def stop(robot: Robot, user: Any, now: datetime | None = None, rung: bool = False) -> None:
    """Stop the robot: on the bus first (if that was not `rung` yet), then in the database.

    Raises:
        NotPermitted: neither staff nor the operator, or one whose turn is over.

    """
    under = _stops_under(robot, user)
    if under is None:
        raise NotPermitted(NOT_THEIRS)
    if not rung:
        bus.ring_stop(robot.slug, under)
    now = now or SYSTEM.now()
    theirs = Robot.objects.filter(pk=robot.pk)
    if under:  # in one statement: a turn may end between the look and the stop
        theirs = theirs.filter(grants__pk=under, grants__ended_at=None)
    if not theirs.update(stop_latched=True, stopped_at=now):
        raise NotPermitted(NOT_THEIRS)
    cancel_queued(robot, "the robot was stopped", now)
    bus.publish_on_commit(robot.slug, Changed("stop"))


def release_stop(robot: Robot, user: Any, checked: bool) -> None:
    """Release a latched stop after an explicit re-check; starts no motion.

    Raises:
        NotPermitted: not the operator nor staff, or the re-check was not confirmed.

    """
    if not may_stop(robot, user):
        raise NotPermitted("Only the operator and staff can release the stop.")
    if not checked:
        raise NotPermitted("Look at the newest picture first, and confirm that the way is clear.")
    with transaction.atomic():
        cancel_queued(robot, "the robot was stopped", SYSTEM.now())  # what was asked for before must not begin now
        Robot.objects.filter(pk=robot.pk).update(stop_latched=False, releases=F("releases") + 1)
    bus.publish_on_commit(robot.slug, Changed("stop"))


def lock_out(robot: Robot, user: Any, note: str) -> None:
    """Take the robot from the public: stop it, keep people's places. Only staff lift it."""
    need_staff(user)
    if not note.strip():
        raise BadRequest("Write a note that says why the robot is locked out.")
    stop(robot, user)
    with transaction.atomic():
        Robot.objects.filter(pk=robot.pk).update(
            cycle=Cycle.LOCKED_OUT, lockout_note=note.strip()[:300], locked_by=user, reason=note.strip()[:300]
        )
        grant = open_grant(robot)
        if grant is not None:
            end_grant(grant, "robot locked out by staff", SYSTEM.now())
        bus.publish_on_commit(robot.slug, Changed("robot"))


def lift_lock_out(robot: Robot, user: Any) -> None:
    """Give the robot back: it is put in order first, then offered."""
    need_staff(user)
    now = SYSTEM.now()
    with transaction.atomic():
        grant = open_grant(robot)
        if grant is not None and grant.kind == GrantKind.STAFF:
            end_grant(grant, "lock-out lifted", now)
        cancel_queued(robot, "the robot was locked out", now)
        Robot.objects.filter(pk=robot.pk, cycle=Cycle.LOCKED_OUT).update(
            cycle=Cycle.HANDOVER,
            lockout_note="",
            locked_by=None,
            reason="",
            stop_latched=False,
            releases=F("releases") + 1,
        )
        bus.publish_on_commit(robot.slug, Changed("robot"))


def start_maintenance(robot: Robot, user: Any, minutes: int = 30) -> Grant:
    """Open a maintenance turn: a keeper drives under lock-out. Raises NotPermitted."""
    need_staff(user)
    robot.refresh_from_db()
    if robot.cycle != Cycle.LOCKED_OUT:
        raise NotPermitted("Lock the robot out first; a maintenance turn runs under lock-out.")
    now = SYSTEM.now()
    grant = open_grant(robot)
    if grant is not None and grant.kind == GrantKind.STAFF and grant.holder_id == user.pk:
        return grant
    return start_grant(robot, GrantKind.STAFF, now, user, now + timedelta(minutes=minutes))


def staff_command(robot: Robot, user: Any, kind: str) -> Command:
    """Run one command of staff (soft reset, calibrate, still): in a maintenance turn of theirs, or by itself.

    By itself it has a grant of its own, which ends when the command ends, however it ends; until
    then nobody is offered the robot. What is refused opens none.

    Raises:
        NotPermitted: not staff; somebody operates the robot, or it is being put in order.
        Stopped, RobotOffline: as for every command.

    """
    need_staff(user)
    now = SYSTEM.now()
    with transaction.atomic():
        robot.refresh_from_db()
        grant = open_grant(robot)
        if grant is None:
            seconds = START_S + _limit_s(kind) + AFTER_S
            grant = start_grant(robot, GrantKind.UPKEEP, now, user, now + timedelta(seconds=seconds))
        elif grant.kind == GrantKind.UPKEEP:
            raise NotPermitted(ONE_COMMAND)
        elif grant.kind == GrantKind.HANDOVER:
            raise NotPermitted("The robot is being put in order; try again when that is done.")
        elif grant.holder_id != user.pk:
            raise NotPermitted("Somebody operates the robot now; lock it out first.")
        return _issue(grant, user, kind, {}, next_seq(grant), now).command


def set_enabled(robot: Robot, user: Any, enabled: bool) -> None:
    """Switch a robot on or off; the supervisor follows."""
    need_staff(user)
    robot.refresh_from_db()
    if not enabled:
        stop(robot, user)
        grant = open_grant(robot)
        if grant is not None:
            end_grant(grant, "robot switched off", SYSTEM.now())
    changes: dict[str, Any] = {"enabled": enabled}
    if enabled and robot.cycle in (Cycle.OFFLINE, Cycle.FAULT):
        changes.update(cycle=Cycle.HANDOVER, reason="", stop_latched=False, releases=F("releases") + 1)
    if not enabled:
        changes.update(cycle=Cycle.OFFLINE, reason="Switched off by staff.")
    with transaction.atomic():
        cancel_queued(robot, "the robot was switched", SYSTEM.now())
        Robot.objects.filter(pk=robot.pk).update(**changes)
    bus.publish_on_commit(robot.slug, Changed("robot"))


def close_incident(incident: Incident, user: Any) -> None:
    """Mark an incident as dealt with."""
    need_staff(user)
    Incident.objects.filter(pk=incident.pk, closed_at=None).update(closed_at=SYSTEM.now())
