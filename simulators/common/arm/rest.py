"""When the control loop may pause: a scene at rest needs no steps, which saves a small computer's processor time.

The loop runs at 500 Hz while anything moves, is about to move or is pushed, and for 0.4 s after. Its time stands
still while it pauses, as it does in a stall; pictures of a scene at rest do not change, so a viewer needs no steps
either.
"""

import threading
from collections.abc import Callable

import numpy as np

from robots.kit.arms.chain import Joints
from robots.kit.clock import TIMER, Timer

STILL = 1e-4  # rad, m: closed fingers tremble by less, and cameras show nothing smaller
EVERY = 50  # steps between two looks at the positions
STEPS = 200  # steps without motion before the loop pauses
LOOK_S = 0.1  # between two looks for faults meanwhile


class Rest:
    """Counts steps without motion; `wake` from any thread ends a rest at once."""

    def __init__(self, clock: Timer = TIMER) -> None:
        self._clock = clock
        self._steps, self._at = 0, np.zeros(0)
        self._woken = threading.Event()

    def wake(self) -> None:
        """Let the loop run, for `STEPS` at least."""
        self._woken.set()

    def reached(self, busy: bool, qpos: Callable[[], Joints]) -> bool:
        """Count one step; return whether nothing in the scene (rad, m) has moved for long enough."""
        if busy or self._woken.is_set():
            self._woken.clear()
            self._steps = 0
            return False
        if self._steps % EVERY == 0:
            here = qpos()
            if self._steps == 0 or np.abs(here - self._at).max() > STILL:
                self._steps, self._at = 0, here
        self._steps += 1
        return self._steps >= STEPS

    def last(self, busy: Callable[[], bool]) -> None:
        """Return when woken, or when `busy` reports work."""
        while not self._clock.wait(self._woken, LOOK_S) and not busy():
            pass
        self._steps = 0
