"""Watches the machine itself: a measurement during which it stalled is discarded."""

import threading
import time  # noqa: TID251 - only timed tests may import it

TICK_S = 0.01
STALL_S = 0.05
STALLED = "the machine stalled"


class Witness(threading.Thread):
    """Sleeps for ten milliseconds at a time and notes where that took far longer."""

    def __init__(self):
        super().__init__(daemon=True)
        self.stalls: list[tuple[float, float]] = []
        self.discarded = 0
        self._running = True
        self.start()

    def run(self):
        while self._running:
            before = time.monotonic()
            time.sleep(TICK_S)
            after = time.monotonic()
            if after - before > STALL_S:
                self.stalls.append((before, after))

    def clean(self, since, until):
        """Tell whether the machine ran well between two times; counts where it did not."""
        well = not any(a < until and b > since for a, b in self.stalls)
        self.discarded += not well
        return well

    def lost(self, since, until):
        """Return for how long the machine stood still between two times (s)."""
        return sum(min(b, until) - max(a, since) for a, b in self.stalls if a < until and b > since)

    def stop(self):
        self._running = False
