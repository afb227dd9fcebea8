"""How often the owner's loops look: often while there is something to look after, seldom on an idle robot."""

import threading

from robots.clock import Clock

LIVELY_S = 3.0


class Pace:
    """Lively for some seconds after each `stir`, idle then; a stir ends every idle wait at once.

    A wake-up, an open grant, a command, a stop and a motion stir; whoever stirs late costs a moment of an idle
    wait, never a promise: stops and keep-alives are heard through a channel of their own.
    """

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._stirred = threading.Condition()
        self._until = clock.monotonic() + LIVELY_S

    @property
    def lively(self) -> bool:
        """Tell whether there is something to look after."""
        return self._clock.monotonic() < self._until

    def stir(self) -> None:
        """Say that there is something to look after."""
        with self._stirred:
            self._until = self._clock.monotonic() + LIVELY_S
            self._stirred.notify_all()

    def sleep(self, lively_s: float, idle_s: float) -> float:
        """Sleep for `lively_s`, or on an idle robot until it is stirred or for `idle_s`; return which was meant (s)."""
        with self._stirred:
            if not self.lively:
                self._stirred.wait(idle_s)
                return idle_s
        self._clock.sleep(lively_s)
        return lively_s
