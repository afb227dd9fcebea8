"""Helpers of drivers: for the permit that they get, and for the wait until the robot rests."""

from collections.abc import Callable

from robots.kit.clock import Limit, Timer
from robots.kit.contract.errors import HardwareFault, MotionHeld
from robots.kit.contract.session import Permit, RobotState


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


def until_at_rest(
    ask: Callable[[], RobotState], clock: Timer, limit_s: float, who: str, pause_s: float = 0.0
) -> RobotState:
    """Ask for the state until nothing moves, which a hold must have reached in `limit_s`; it is asked at least once.

    Raises HardwareFault where it does not come to rest, and what `ask` raises.
    """
    limit = Limit(clock, limit_s)
    while (state := ask()).moving:
        if limit.over:
            raise HardwareFault(f"{who} did not come to rest after a hold.")
        if pause_s:
            clock.sleep(pause_s)
    return state
