"""The person behind a socket: the role in the last snapshot, and the account, which every command reads again."""

from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

from django.conf import settings
from django.contrib import auth
from django.contrib.auth.models import AnonymousUser
from django.contrib.sessions.models import Session
from django.db.models import BigAutoField, CharField, DateTimeField, Subquery
from django.utils.crypto import constant_time_compare

from accounts.services import is_seen
from accounts.sessions import SessionStore
from portal.live.threads import ANYBODY, DRIVERS, KNOWN, Pool
from robots.kit.clock import SYSTEM
from robots.prepared import Prepared, Slot

LAST = "farhand.person"  # in a socket's scope: the id of the person whom Django returned last
ID, KEY, NOW = Slot("id", BigAutoField()), Slot("key", CharField()), Slot("now", DateTimeField())
_PERSON: Prepared[Any] = Prepared(
    lambda: auth.get_user_model()._default_manager.filter(pk=ID).annotate(
        session=Subquery(Session.objects.filter(session_key=KEY, expire_date__gt=NOW).values("session_data"))
    )
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Role:
    """The person of a socket and their rights there, as of the last snapshot.

    It decides about messages that do not wait for the database; a command is judged by the database.
    """

    person: int = 0  # their key; 0: nobody, or not known yet
    anonymous: bool = False  # nobody is signed in
    grant: int = 0  # the key of the open grant under which they drive the robot; 0: they do not drive
    staff: bool = False
    queued: bool = False  # they have a place in a queue

    @property
    def may_stop(self) -> bool:
        """Return whether a Stop goes to the robot at once."""
        return self.staff or self.grant > 0

    @property
    def stop_grant(self) -> int:
        """Return the grant that a Stop names, so that it counts for no later one; staff name none (0)."""
        return 0 if self.staff else self.grant

    @property
    def pool(self) -> Pool:
        """Return the threads for queries of this person."""
        return DRIVERS if self.grant else KNOWN if self.staff or self.queued else ANYBODY


def session_key(scope: dict[str, Any]) -> str:
    """Return the key of the session with which the socket was opened; empty without one."""
    return str(scope.get("cookies", {}).get(settings.SESSION_COOKIE_NAME, ""))


def current_user(scope: dict[str, Any]) -> Any:
    """Return the person of the socket's session; anonymous after a sign-out."""
    key = session_key(scope)
    if not key or "\x00" in key:
        return AnonymousUser()
    user = _same(scope.get(LAST, 0), key)
    if user is None:
        user = auth.get_user(SimpleNamespace(session=SessionStore(key)))  # type: ignore[arg-type]
        scope[LAST] = user.pk or 0
    slug = scope.get("url_route", {}).get("kwargs", {}).get("slug")  # None: the person's own socket
    return user if user.is_active and (slug is None or is_seen(user, slug)) else AnonymousUser()


def _same(person: int, key: str) -> Any:
    """Return this person if Django would return the same, else None; person and session are read in one statement.

    It checks what `auth.get_user` does: the session is there and not over, its signature is right, it is this person's,
    by a backend in use, and made with the present password; and the account is active.
    """
    for user in _PERSON(id=person, key=key, now=SYSTEM.now()) if person else ():
        kept = SessionStore().decode(user.session) if user.session else {}
        if (
            kept.get(auth.SESSION_KEY) == str(user.pk)
            and kept.get(auth.BACKEND_SESSION_KEY) in settings.AUTHENTICATION_BACKENDS
            and constant_time_compare(kept.get(auth.HASH_SESSION_KEY) or "", user.get_session_auth_hash())
            and user.is_active
        ):
            return user
    return None
