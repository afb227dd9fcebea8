"""How often the owner's loops look: often while the robot is in use, seldom while it is idle."""

import threading

from robots.clock import Clock

LIVELY_S = 3.0


class Pace:
    """Lively for some seconds after each `stir`, idle afterwards; a stir ends every idle wait at once.

    Wake-ups, open grants, commands, stops and motions stir. A late stir costs part of an idle wait and breaks no
    promise: stops and keep-alives arrive over a channel of their own.
    """

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._stirred = threading.Condition()
        self._until = clock.monotonic() + LIVELY_S

    @property
    def lively(self) -> bool:
        """Return whether the robot is in use."""
        return self._clock.monotonic() < self._until

    def stir(self) -> None:
        """Note that the robot is in use."""
        with self._stirred:
            self._until = self._clock.monotonic() + LIVELY_S
            self._stirred.notify_all()

    def sleep(self, lively_s: float, idle_s: float) -> float:
        """Sleep for `lively_s`; on an idle robot for `idle_s` or until a stir. Return the chosen time (s)."""
        with self._stirred:
            if not self.lively:
                self._stirred.wait(idle_s)
                return idle_s
        self._clock.sleep(lively_s)
        return lively_s
