"""What drivers add to the permit that they are given."""

from collections.abc import Callable

from robots.contract.session import Permit
from robots.drivers.errors import Held


def until_held(permit: Permit, holds: Callable[[], int]) -> Permit:
    """Return `permit`, which from now on also raises Held once `holds` counts one more hold.

    A hold by another thread ends a command for good, whatever the permit says by then.
    """
    before = holds()

    def check() -> None:
        permit()
        if holds() != before:
            raise Held("The motion was stopped on its way.")

    return check
