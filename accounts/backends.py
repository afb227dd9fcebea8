"""Sign-in in constant time, whether the account exists or not; and permissions that follow from clearances."""

from typing import Any

from allauth.account.auth_backends import AuthenticationBackend
from allauth.account.internal.userkit import filter_users_by_email, get_user_by_username
from django.contrib.auth.backends import BaseBackend
from django.contrib.auth.base_user import AbstractBaseUser
from django.db.models import BigAutoField
from django.http import HttpRequest

from accounts.models import User
from accounts.services import cleared
from robots.models import Robot
from robots.prepared import Prepared, Slot
from robots.services.permissions import LEVEL

_PERSON: Prepared[User] = Prepared(lambda: User.objects.filter(pk=Slot("id", BigAutoField())))


class ConstantTimeBackend(AuthenticationBackend):  # type: ignore[misc]
    """allauth's backend, with exactly one password hash for each attempt.

    allauth's own backend looks up a name as address and as handle, for both names that the form passes. With Django's
    backend beside it, an existing account cost three hashes and an unknown one two, so the time of the answer showed
    which addresses have an account.
    """

    def _authenticate(self, request: HttpRequest | None, **credentials: Any) -> AbstractBaseUser | None:
        name = str(credentials.get("email") or credentials.get("username") or "")
        found = filter_users_by_email(name, prefer_verified=True, for_login=True) if "@" in name else None
        user = found[0] if found else get_user_by_username(name)
        known: AbstractBaseUser | None = self._check_password(user, str(credentials.get("password") or ""))
        return known

    def get_user(self, user_id: Any) -> AbstractBaseUser | None:
        """Return the person with a prepared statement, because every page reads it."""
        found = _PERSON.first(id=user_id)
        return found if found is not None and self.user_can_authenticate(found) else None


class ClearanceBackend(BaseBackend):
    """Answers `has_perm("robots.level_2", robot)`: whether the clearance reaches the level. It signs nobody in.

    `robots`, which may not import this app, asks in this way.
    """

    def has_perm(self, user_obj: Any, perm: str, obj: Any = None) -> bool:
        """Return whether the clearance for the robot `obj` reaches the level that `perm` ends with."""
        level = perm.removeprefix(LEVEL)
        return isinstance(obj, Robot) and level != perm and level.isdecimal() and cleared(user_obj, obj, int(level))
