"""The stop and its release."""

from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import Any

from django.db import transaction
from django.db.models import Case, F, OuterRef, Subquery, When
from django.db.models.functions import Coalesce

from robots import bus
from robots.grants import cancel_queued, lease_of, open_grant, owner_alive, rests_within
from robots.kit.clock import SYSTEM
from robots.kit.contract.errors import NotPermitted
from robots.kit.contract.procedures import PICTURE
from robots.kit.packets import Changed
from robots.models import Command, Lease, Robot
from robots.states import Lane

NEWEST = Coalesce(Subquery(Command.objects.filter(robot=OuterRef("pk")).order_by("-id").values("pk")[:1]), 0)
NOT_THEIRS = "Only the operator and staff can stop this robot."


def may_stop(robot: Robot, user: Any) -> bool:
    """Return whether this person may stop the robot: the holder of the open grant, and staff."""
    return _stops_under(robot, user) is not None


def _stops_under(robot: Robot, user: Any) -> int | None:
    """Return the grant under which this person stops the robot; 0 for staff, None for others."""
    if user is None or not user.is_authenticated:
        return None
    if user.has_perm("robots.change_robot"):
        return 0
    grant = open_grant(robot)
    return grant.pk if grant is not None and grant.holder_id == user.pk else None


def stop(robot: Robot, user: Any, now: datetime | None = None, sent: bool = False) -> None:
    """Stop the robot: over the bus first (unless it was `sent` there already), then in the database.

    Raises:
        NotPermitted: neither staff nor the operator of an open turn.
    """
    under = _stops_under(robot, user)
    if under is None:
        raise NotPermitted(NOT_THEIRS)
    if not sent:
        bus.send_stop(robot.slug, under)
    now = now or SYSTEM.now()
    theirs = Robot.objects.filter(pk=robot.pk)
    if under:  # in one statement: the turn may end between the check and the stop
        theirs = theirs.filter(grants__pk=under, grants__ended_at=None)
    # only the owner confirms the stop, and says by when the robot rests; an earlier stop's answers do not count
    said = {
        "stop_confirmed": Case(When(stop_latched=True, then=F("stop_confirmed")), default=False),
        "rests_by": Case(When(stop_latched=True, then=F("rests_by")), default=None),
    }
    if not theirs.update(stop_latched=True, stopped_at=now, stopped_after=NEWEST, **said):
        raise NotPermitted(NOT_THEIRS)
    cancel_queued(robot, "the robot was stopped", now)
    bus.publish_on_commit(robot.slug, Changed("stop"))


def asked_since_stop(robot: Robot) -> bool:
    """Return whether anybody has moved the robot since it was stopped last; True if it never was.

    A release starts no motion, so until then the robot stays where it is. The keys of commands are compared, because
    the time of day may be set.
    """
    before = Robot.objects.values_list("stopped_after", flat=True).get(pk=robot.pk)
    motions = Command.objects.filter(robot=robot, lane=Lane.MOTION, accepted_at__isnull=False)
    return before is None or motions.filter(pk__gt=before).exclude(kind=PICTURE.kind).exists()


CONFIRMED = timedelta(seconds=1)  # a page mentions a missing confirmation only after this time


@dataclass(frozen=True)
class StopShown:
    """A latched stop: whether the robot confirmed that it rests, since when, and when it rests at the latest."""

    confirmed: bool
    since: datetime | None
    rests_by: datetime | None
    overdue: bool = False  # the confirmation is later than it may be


def stop_shown(robot: Robot, now: datetime) -> StopShown | None:
    """Return what is known of the latched stop; None if there is none.

    Without an owner, the robot comes to rest by itself after the time that its spec declares, because nothing was sent
    to it after the stop or after the end of its owner's lease.
    """
    if not robot.stop_latched:
        return None
    if robot.stop_confirmed:
        return StopShown(True, robot.stopped_at, None)
    rests_by, lease = robot.rests_by, lease_of(robot)
    if rests_by is None and not owner_alive(lease, now):
        rests_by = _rests_by_itself(robot, lease)
    overdue = rests_by is not None or robot.stopped_at is None or now - robot.stopped_at >= CONFIRMED
    return StopShown(False, robot.stopped_at, rests_by, overdue)


def _rests_by_itself(robot: Robot, lease: Lease | None) -> datetime | None:
    rest_s = rests_within(robot, robot.settings)
    known = [at for at in (robot.stopped_at, lease and lease.expires_at) if at]
    return max(known) + timedelta(seconds=rest_s) if known and rest_s is not None else None


def release_stop(robot: Robot, user: Any, checked: bool) -> None:
    """Release a latched stop after the person has checked the robot; starts no motion.

    Raises:
        NotPermitted: neither operator nor staff, or the check was not confirmed.
    """
    if not may_stop(robot, user):
        raise NotPermitted("Only the operator and staff can release the stop.")
    if not checked:
        raise NotPermitted("Look at the newest picture first, and confirm that the way is clear.")
    with transaction.atomic():
        cancel_queued(robot, "the robot was stopped", SYSTEM.now())  # earlier requests must not start now
        Robot.objects.filter(pk=robot.pk).update(stop_latched=False, releases=F("releases") + 1)
    bus.publish_on_commit(robot.slug, Changed("stop"))
