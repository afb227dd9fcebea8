"""Compares a person with the person of a row, and names the latter for everybody."""

from typing import Any

DELETED = "Deleted account"


def handle_of(person: Any) -> str:
    """Return a person's handle; None stands for a person whose account was deleted."""
    return DELETED if person is None else str(person.get_username())


def is_person(visitor: Any, pk: Any) -> bool:
    """Return whether the visitor is the person with this key; no visitor is the person of a deleted account (None)."""
    return pk is not None and pk == getattr(visitor, "pk", None)
