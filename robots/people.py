"""Compares a person with the person of a row, and names the latter for everybody."""

from typing import Any

from django.utils.translation import gettext, gettext_noop

DELETED = gettext_noop("Deleted account")  # it has a space, so it is nobody's handle
STAFF = gettext_noop("staff")  # in place of a handle; nobody may have it as one
SOMEBODY = gettext_noop("somebody")  # in place of the handle of who does not want it shown; as `STAFF`


def handle_of(person: Any) -> str:
    """Return a person's handle; None stands for a person whose account was deleted."""
    return DELETED if person is None else str(person.get_username())


def sees_names(viewer: Any) -> bool:
    """Return whether the viewer reads the handles also of drivers who do not want theirs shown, as staff do."""
    return bool(getattr(viewer, "is_staff", False))


def driver_name(person: Any, viewer: Any = None) -> str:
    """Return the handle of who drives or has driven, or `SOMEBODY` if they do not want it shown to this viewer.

    Whatever tells others than staff who drives asks here. What a person publishes has the name of `handle_of`.
    """
    hidden = person is not None and not person.name_shown and not is_person(viewer, person.pk)
    return SOMEBODY if hidden and not sees_names(viewer) else handle_of(person)


def shown_name(handle: str) -> str:
    """Return a handle as a page shows it: the words that stand in place of one are in the reader's language."""
    return gettext(handle) if handle in (DELETED, STAFF, SOMEBODY) else handle


def is_person(visitor: Any, pk: Any) -> bool:
    """Return whether the visitor is the person with this key; no visitor is the person of a deleted account (None)."""
    return pk is not None and pk == getattr(visitor, "pk", None)
