"""Who may change whose account: nobody one that may do more than they may."""

from typing import Any

from django.contrib.auth.models import Permission
from django.db.models import Q

from accounts.models import Clearance


def may_do_more(other: Any, user: Any) -> bool:
    """Return whether the account `other` has a right that `user` has not, also while it is switched off."""
    if user.is_superuser or other.pk == user.pk:
        return False
    return bool(other.is_superuser or _rights(other) - _rights(user))


def drives_more(other: Any, user: Any) -> bool:
    """Return whether `other` is cleared for what `user` is not; who gives clearances gives none to themselves."""
    if user.is_superuser or other.pk == user.pk:
        return False
    levels = dict(_levels(user))
    return any(level > levels.get(robot, 0) for robot, level in _levels(other))


def _rights(user: Any) -> set[tuple[str, str]]:
    """Return the permissions by app and name; `get_all_permissions` has none of an account that is switched off."""
    found = Permission.objects.filter(Q(user=user) | Q(group__user=user))
    return set(found.values_list("content_type__app_label", "codename"))


def _levels(user: Any) -> Any:
    """Return robots and levels, the highest level of a robot last."""
    return Clearance.objects.filter(user=user, revoked_at=None).order_by("level").values_list("robot", "level")
