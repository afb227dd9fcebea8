"""Waits until the robot rests."""

from collections.abc import Callable

from robots.kit.clock import Limit, Timer
from robots.kit.contract.errors import HardwareFault
from robots.kit.contract.session import RobotState


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
