"""Who is on the other end of a socket, asked again at every command."""

from importlib import import_module
from types import SimpleNamespace
from typing import Any

from django.conf import settings
from django.contrib import auth
from django.contrib.auth.models import AnonymousUser


def current_user(scope: dict[str, Any]) -> Any:
    """Return the person that the socket's session belongs to now; anonymous after a logout."""
    key = scope["session"].session_key if scope.get("session") else None
    if not key:
        return AnonymousUser()
    store = import_module(settings.SESSION_ENGINE).SessionStore(key)
    user = auth.get_user(SimpleNamespace(session=store))  # type: ignore[arg-type]
    return user if user.is_active else AnonymousUser()
