"""Who a name and a password belong to, found in the same time whether there is such an account or not."""

from typing import Any

from allauth.account.auth_backends import AuthenticationBackend
from allauth.account.internal.userkit import filter_users_by_email, get_user_by_username
from django.contrib.auth.base_user import AbstractBaseUser
from django.http import HttpRequest


class OneLook(AuthenticationBackend):  # type: ignore[misc]
    """allauth's backend, with one password hashed at each attempt.

    Its own looks a name up as address and as handle, and once more for each of the two that the
    form passes; with Django's backend beside it an account that exists cost three hashes and one
    that does not two, so the time of the answer told which addresses have an account.
    """

    def _authenticate(self, request: HttpRequest | None, **credentials: Any) -> AbstractBaseUser | None:
        name = str(credentials.get("email") or credentials.get("username") or "")
        found = filter_users_by_email(name, prefer_verified=True, for_login=True) if "@" in name else None
        user = found[0] if found else get_user_by_username(name)
        known: AbstractBaseUser | None = self._check_password(user, str(credentials.get("password") or ""))
        return known
