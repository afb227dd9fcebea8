"""Compares a person with the person of a row, and names the latter for everybody."""

from typing import Any

from django.utils.translation import gettext, gettext_noop

DELETED = gettext_noop("Deleted account")  # it has a space, so it is nobody's handle
STAFF = gettext_noop("staff")  # in place of a handle; nobody may have it as one


def handle_of(person: Any) -> str:
    """Return a person's handle; None stands for a person whose account was deleted."""
    return DELETED if person is None else str(person.get_username())


def shown_name(handle: str) -> str:
    """Return a handle as a page shows it: staff, and deleted accounts, are named in the reader's language."""
    return gettext(handle) if handle in (DELETED, STAFF) else handle


def is_person(visitor: Any, pk: Any) -> bool:
    """Return whether the visitor is the person with this key; no visitor is the person of a deleted account (None)."""
    return pk is not None and pk == getattr(visitor, "pk", None)
