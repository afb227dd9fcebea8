"""The person behind a socket, read again for every command."""

from importlib import import_module
from types import SimpleNamespace
from typing import Any

from django.conf import settings
from django.contrib import auth
from django.contrib.auth.models import AnonymousUser


def session_key(scope: dict[str, Any]) -> str:
    """Return the key of the session with which the socket was opened; empty without one."""
    return str(scope.get("cookies", {}).get(settings.SESSION_COOKIE_NAME, ""))


def current_user(scope: dict[str, Any]) -> Any:
    """Return the person of the socket's session; anonymous after a sign-out."""
    key = session_key(scope)
    if not key or "\x00" in key:
        return AnonymousUser()
    store = import_module(settings.SESSION_ENGINE).SessionStore(key)
    user = auth.get_user(SimpleNamespace(session=store))  # type: ignore[arg-type]
    return user if user.is_active else AnonymousUser()
