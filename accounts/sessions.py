"""Sessions: Django's, read with a prepared statement. They end when their account is switched off or deleted."""

from collections.abc import Collection
from typing import Any

from django.conf import settings
from django.contrib import auth
from django.contrib.sessions.backends import db
from django.contrib.sessions.models import Session
from django.db.models import CharField, DateTimeField
from django.db.models.signals import post_save, pre_delete, pre_save
from django.dispatch import receiver
from django.utils import timezone

from accounts.push import unsubscribe_all
from robots.prepared import Prepared, Slot

_OPEN: Prepared[Session] = Prepared(
    lambda: Session.objects.filter(
        session_key=Slot("key", CharField()), expire_date__gt=Slot("now", DateTimeField())
    )
)  # fmt: skip


class SessionStore(db.SessionStore):
    """Django's session store; the name is the same because the data are signed with it."""

    def _get_session_from_db(self) -> Any:
        found = _OPEN.first(key=self.session_key, now=timezone.now())
        if found is None:
            self._session_key = None
        return found


def end_sessions(person: Any) -> None:
    """Delete the rows of the person's sessions, and tell none of their browsers any more."""
    unsubscribe_all(person)
    mine = [s.pk for s in Session.objects.iterator() if s.get_decoded().get(auth.SESSION_KEY) == str(person.pk)]
    Session.objects.filter(pk__in=mine).delete()


@receiver(pre_delete, sender=settings.AUTH_USER_MODEL)
def end_of_deleted(instance: Any, **_: Any) -> None:
    """End the sessions of an account with it. Not of a guest: there are many, and the session shows nothing then."""
    if not instance.guest:
        end_sessions(instance)


@receiver(pre_save, sender=settings.AUTH_USER_MODEL)
def note_switching_off(instance: Any, update_fields: Collection[str] | None = None, **_: Any) -> None:
    """Note whether this switches the account off; only then all sessions are read."""
    stored = not instance.is_active and (update_fields is None or "is_active" in update_fields)
    instance.goes_off = stored and type(instance).objects.filter(pk=instance.pk, is_active=True).exists()


@receiver(post_save, sender=settings.AUTH_USER_MODEL)
def end_of_switched_off(instance: Any, **_: Any) -> None:
    """End the sessions of an account that is switched off, so that none works again when it is switched on."""
    if instance.goes_off:
        end_sessions(instance)
