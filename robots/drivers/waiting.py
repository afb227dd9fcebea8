"""How drivers wait: until something is so, or a limit is over."""

from collections.abc import Callable

from robots.clock import Timer
from robots.contract.session import RobotState
from robots.drivers.errors import HardwareFault


class Limit:
    """So many seconds by a clock, from now on."""

    def __init__(self, clock: Timer, seconds: float) -> None:
        self._clock, self._until = clock, clock.monotonic() + seconds

    @property
    def left(self) -> float:
        """The seconds that are left; not above zero once they have passed."""
        return self._until - self._clock.monotonic()

    @property
    def over(self) -> bool:
        """Whether they have passed."""
        return self.left < 0


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
