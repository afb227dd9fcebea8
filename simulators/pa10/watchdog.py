"""The watchdog of Dziemian et al. 2004, figure 4 (b): a thread that looks whether anybody is there."""

import threading
import time
from collections.abc import Callable

from simulators.pa10.server import Network

LOOK_S = 0.1


def watch(network: Network, silence_s: float, nobody_s: float, again: Callable[[str], None]) -> None:
    """Start the application again where the owner says nothing for so long, or where nobody comes."""

    def look() -> None:
        while True:
            time.sleep(LOOK_S)
            network.watch(silence_s, nobody_s, again)

    threading.Thread(target=look, name="watchdog", daemon=True).start()
