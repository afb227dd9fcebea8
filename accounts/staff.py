"""Verbs of staff on clearances: withdraw one, and allow the test again. Each verb checks the permission."""

from datetime import datetime
from typing import Any

from django.contrib.auth.models import Permission
from django.db.models import Q
from django.utils.translation import gettext

from accounts.models import Clearance
from robots.kit.contract.errors import BadRequest
from robots.services.permissions import NotStaff

LONGEST = 200


def _need(user: Any, clearance: Clearance, note: str) -> str:
    if user is None or not user.has_perm("accounts.change_clearance"):
        raise NotStaff(gettext("This is for staff who may change clearances."))
    if may_do_more(clearance.user, user):
        words = gettext("{user} has rights that you have not; a superuser decides on this clearance.")
        raise NotStaff(words.format(user=clearance.user))
    note = note.strip()
    if not 0 < len(note) <= LONGEST:
        words = gettext("Write a note of at most {count} characters; the person reads it.")
        raise BadRequest(words.format(count=LONGEST))
    return note


def withdraw(clearance: Clearance, user: Any, note: str, now: datetime) -> bool:
    """Withdraw a clearance until staff lift that. Return False if it is withdrawn already.

    Raises NotStaff, BadRequest.
    """
    note = _need(user, clearance, note)
    mine = Clearance.objects.filter(pk=clearance.pk, revoked_at=None)
    return bool(mine.update(revoked_at=now, lifted_at=None, note=note, decided_by=user))


def lift(clearance: Clearance, user: Any, note: str, now: datetime) -> bool:
    """Let the person pass the test again after a withdrawal. Return False if none was withdrawn.

    Raises:
        NotStaff: no permission, or the user's own clearance.
        BadRequest: no note.
    """
    note = _need(user, clearance, note)
    if clearance.user_id == user.pk and not user.is_superuser:
        raise NotStaff(gettext("Nobody decides on a clearance of their own; ask other staff."))
    mine = Clearance.objects.filter(pk=clearance.pk, revoked_at__isnull=False, lifted_at=None)
    return bool(mine.update(lifted_at=now, note=note, decided_by=user))


def may_do_more(other: Any, user: Any) -> bool:
    """Return whether the account `other` has a right that `user` has not, even if `other` is switched off."""
    if user.is_superuser or other.pk == user.pk:
        return False
    return bool(other.is_superuser or _rights(other) - _rights(user))


def drives_more(other: Any, user: Any) -> bool:
    """Return whether `other` has a clearance that `user` has not; nobody gives clearances to themselves."""
    if user.is_superuser or other.pk == user.pk:
        return False
    levels = dict(_levels(user))
    return any(level > levels.get(robot, 0) for robot, level in _levels(other))


def _rights(user: Any) -> set[tuple[str, str]]:
    """Return the permissions by app and name; `get_all_permissions` is empty for an account that is switched off."""
    found = Permission.objects.filter(Q(user=user) | Q(group__user=user))
    return set(found.values_list("content_type__app_label", "codename"))


def _levels(user: Any) -> Any:
    """Return robots and levels, the highest level of a robot last."""
    return Clearance.objects.filter(user=user, revoked_at=None).order_by("level").values_list("robot", "level")
