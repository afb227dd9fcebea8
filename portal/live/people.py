"""The person behind a socket, read again for every command."""

from importlib import import_module
from types import SimpleNamespace
from typing import Any

from django.conf import settings
from django.contrib import auth
from django.contrib.auth.models import AnonymousUser
from django.contrib.sessions.backends import db
from django.contrib.sessions.models import Session
from django.db.models import CharField, DateTimeField

from robots.clock import SYSTEM
from robots.prepared import Prepared, Slot

KEY, NOW = Slot("key", CharField()), Slot("now", DateTimeField())
_SESSION: Prepared[Session] = Prepared(lambda: Session.objects.filter(session_key=KEY, expire_date__gt=NOW))


class Store(db.SessionStore):
    """Django's own sessions in the database, read by a statement that is made once."""

    key_salt = db.SessionStore().key_salt  # the name of the class is a part of it

    def _get_session_from_db(self) -> Session | None:
        for found in _SESSION(key=self.session_key, now=SYSTEM.now()):
            return found
        self._session_key = None
        return None


def session_key(scope: dict[str, Any]) -> str:
    """Return the key of the session with which the socket was opened; empty without one."""
    return str(scope.get("cookies", {}).get(settings.SESSION_COOKIE_NAME, ""))


def current_user(scope: dict[str, Any]) -> Any:
    """Return the person of the socket's session; anonymous after a sign-out."""
    key = session_key(scope)
    if not key or "\x00" in key:
        return AnonymousUser()
    engine = import_module(settings.SESSION_ENGINE)
    store = Store(key) if engine is db else engine.SessionStore(key)
    user = auth.get_user(SimpleNamespace(session=store))  # type: ignore[arg-type]
    return user if user.is_active else AnonymousUser()
