"""The watchdog of Dziemian et al. 2004, figure 4 (b): a thread that checks whether anybody is connected."""

from collections.abc import Callable

from robots.kit.clock import TIMER, Timer
from simulators.pa10.server import Network

LOOK_S = 0.1


def watch(
    network: Network, silence_s: float, nobody_s: float, again: Callable[[str], None], clock: Timer = TIMER
) -> None:
    """Restart the application if the owner is silent for so long, or if nobody connects."""

    def look() -> None:
        while True:
            clock.sleep(LOOK_S)
            network.watch(silence_s, nobody_s, again)

    clock.spawn(look, "watchdog")
