"""Helpers for the permit that drivers get."""

from collections.abc import Callable

from robots.kit.contract.errors import MotionHeld
from robots.kit.contract.session import Permit


def unless_held(holds: Callable[[], int], words: str = "The motion was stopped on its way.") -> Permit:
    """Return a check that raises MotionHeld, with `words`, once `holds` has counted another hold from now on."""
    before = holds()

    def check() -> None:
        if holds() != before:
            raise MotionHeld(words)

    return check


def until_held(permit: Permit, holds: Callable[[], int]) -> Permit:
    """Return `permit`, which from now on also raises MotionHeld once `holds` has counted another hold.

    A hold by another thread ends a command for good, whatever the permit says afterwards.
    """
    free = unless_held(holds)

    def check() -> None:
        permit()
        free()

    return check
