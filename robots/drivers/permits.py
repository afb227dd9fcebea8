"""Helpers for the permit that drivers get."""

from collections.abc import Callable

from robots.contract.session import Permit
from robots.drivers.errors import Held


def until_held(permit: Permit, holds: Callable[[], int]) -> Permit:
    """Return `permit`, which from now on also raises Held once `holds` has counted another hold.

    A hold by another thread ends a command for good, whatever the permit says afterwards.
    """
    before = holds()

    def check() -> None:
        permit()
        if holds() != before:
            raise Held("The motion was stopped on its way.")

    return check
