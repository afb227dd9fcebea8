"""Wakes the check of open sockets when a session, an account or a clearance changed."""

from typing import Any

from django.contrib.auth import SESSION_KEY
from django.contrib.sessions.models import Session
from django.db import transaction
from django.db.models.signals import post_delete, post_save

from accounts.models import Clearance, User
from robots import bus


def listen() -> None:
    """Connect the signals of sessions, people and clearances."""
    post_delete.connect(_session_gone, Session, dispatch_uid="sockets: session")
    post_save.connect(_person, User, dispatch_uid="sockets: person")
    post_delete.connect(_person, User, dispatch_uid="sockets: person gone")
    post_save.connect(_clearance, Clearance, dispatch_uid="sockets: clearance")
    post_delete.connect(_clearance, Clearance, dispatch_uid="sockets: clearance gone")


def _announce(person: int) -> None:
    transaction.on_commit(lambda: bus.send_session_changed(person), robust=True)


def _session_gone(instance: Session, **_: Any) -> None:
    person = instance.get_decoded().get(SESSION_KEY)
    if person:
        _announce(int(person))


def _person(instance: User, update_fields: Any = None, **_: Any) -> None:
    if update_fields is None or set(update_fields) & {"is_active", "password"}:
        _announce(instance.pk)


def _clearance(instance: Clearance, **_: Any) -> None:
    _announce(instance.user_id)
