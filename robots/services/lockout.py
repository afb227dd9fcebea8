"""Closes a robot to the public and opens it again: the lock-out with its maintenance turns, and the switch."""

from collections.abc import Iterator
from contextlib import contextmanager
from datetime import timedelta
from typing import Any

from django.db import transaction

from robots import bus
from robots.grants import cancel_queued, end_grant, open_grant, start_grant
from robots.kit.clock import SYSTEM
from robots.kit.contract.errors import BadRequest, NotPermitted
from robots.kit.packets import Changed
from robots.models import Grant, Robot
from robots.people import is_person
from robots.services.commands import need_worker
from robots.services.permissions import need_staff
from robots.services.stopping import stop
from robots.states import Cycle, GrantEnd, GrantKind

OFF = "Switched off by staff."
LONGEST_NOTE = 280  # characters; its sentence fits the reason of a robot


def note_said(quoted: str) -> str:
    """Return the sentence in which people read what staff wrote; its translation leaves that as it is."""
    return f"Staff write: “{quoted}”"


def lock_out(robot: Robot, user: Any, note: str) -> None:
    """Stop the robot and close it to the public; people keep their places. Raises NotStaff, BadRequest."""
    need_staff(user)
    note = note.strip()[:LONGEST_NOTE]
    if not note:
        raise BadRequest("Write a note that says why the robot is locked out.")
    stop(robot, user)
    with transaction.atomic(), _without_grant(robot, GrantEnd.LOCKED_OUT, "robot locked out by staff"):
        Robot.objects.filter(pk=robot.pk).update(
            cycle=Cycle.LOCKED_OUT, lockout_note=note, locked_by=user, reason=note_said(note)
        )
        bus.publish_on_commit(robot.slug, Changed("robot"))


@contextmanager
def _without_grant(robot: Robot, code: GrantEnd, reason: str) -> Iterator[None]:
    """End the open grant before the block writes the robot's row, and a grant opened meanwhile after it.

    This order avoids a deadlock: everybody else who ends a grant also locks the grant before the robot.
    """
    _end_open(robot, code, reason)
    yield
    _end_open(robot, code, reason)


def _end_open(robot: Robot, code: GrantEnd, reason: str) -> None:
    grant = open_grant(robot)
    if grant is not None and grant.kind != GrantKind.REST:
        end_grant(grant, code, reason, SYSTEM.now())


def lift_lock_out(robot: Robot, user: Any) -> None:
    """Open the robot again, stopped: it is verified, then offered. A robot that is switched off stays off.

    It is stopped once more, because staff may have released the stop to drive it. Raises NotStaff, NotPermitted.
    """
    need_staff(user)
    if not Robot.objects.filter(pk=robot.pk, cycle=Cycle.LOCKED_OUT).exists():
        raise NotPermitted("The robot is not locked out.")
    stop(robot, user)
    now = SYSTEM.now()
    with transaction.atomic():
        grant = open_grant(robot)
        if grant is not None and grant.kind == GrantKind.STAFF:
            end_grant(grant, GrantEnd.STAFF, "lock-out lifted", now)
        locked = Robot.objects.filter(pk=robot.pk, cycle=Cycle.LOCKED_OUT)
        free: dict[str, Any] = {"lockout_note": "", "locked_by": None}
        locked.filter(enabled=True).update(cycle=Cycle.HANDOVER, reason="", **free)
        locked.filter(enabled=False).update(cycle=Cycle.OFFLINE, reason=OFF, **free)
        bus.publish_on_commit(robot.slug, Changed("robot"))


def set_enabled(robot: Robot, user: Any, enabled: bool) -> None:
    """Switch a robot on or off; the supervisor starts or stops its worker. A lock-out and a stop stay."""
    need_staff(user)
    if not enabled:
        stop(robot, user)
    now, row = SYSTEM.now(), Robot.objects.filter(pk=robot.pk)
    with transaction.atomic():
        if enabled:
            row.update(enabled=True)
            row.filter(cycle__in=(Cycle.OFFLINE, Cycle.FAULT)).update(cycle=Cycle.HANDOVER, reason="")
        else:
            with _without_grant(robot, GrantEnd.SWITCHED_OFF, "robot switched off"):
                row.update(enabled=False)  # an offer accepted at this moment waits for the row, and then is refused
                row.exclude(cycle=Cycle.LOCKED_OUT).update(cycle=Cycle.OFFLINE, reason=OFF)
        cancel_queued(robot, "the robot was switched", now)
        bus.publish_on_commit(robot.slug, Changed("robot"))
    robot.refresh_from_db()


def start_maintenance(robot: Robot, user: Any, minutes: int = 30) -> Grant:
    """Open a maintenance turn, in which staff drive a robot that is locked out. Raises NotPermitted, RobotOffline."""
    need_staff(user)
    robot.refresh_from_db()
    if robot.cycle != Cycle.LOCKED_OUT:
        raise NotPermitted("Lock the robot out first; a maintenance turn runs under lock-out.")
    now = SYSTEM.now()
    need_worker(robot, now)
    grant = open_grant(robot)
    if grant is not None and grant.kind == GrantKind.STAFF and grant.holder_id == user.pk:
        return grant
    return start_grant(robot, GrantKind.STAFF, now, user, now + timedelta(minutes=minutes))


def end_maintenance(robot: Robot, user: Any) -> bool:
    """End the maintenance turn; the robot stays locked out. Return False if there is none.

    Its holder may end it, and staff. Raises NotStaff.
    """
    grant = open_grant(robot)
    if grant is None or grant.kind != GrantKind.STAFF:
        return False
    own = user is not None and is_person(user, grant.holder_id)
    if not own:
        need_staff(user)
    return end_grant(grant, GrantEnd.HOLDER if own else GrantEnd.STAFF, "maintenance ended", SYSTEM.now())
