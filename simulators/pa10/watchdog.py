"""The watchdog of Dziemian et al. 2004, figure 4 (b): a thread that checks whether anybody is connected."""

import threading
import time
from collections.abc import Callable

from simulators.pa10.server import Network

LOOK_S = 0.1


def watch(network: Network, silence_s: float, nobody_s: float, again: Callable[[str], None]) -> None:
    """Restart the application if the owner is silent for so long, or if nobody connects."""

    def look() -> None:
        while True:
            time.sleep(LOOK_S)
            network.watch(silence_s, nobody_s, again)

    threading.Thread(target=look, name="watchdog", daemon=True).start()
