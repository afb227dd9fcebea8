"""The pace of a control loop: a step each 2 ms of its clock; late steps are made up for, but not many of them."""

from robots.kit.clock import Timer
from simulators.common.arm.scene import STEP_S

CATCH_UP = 25  # steps made up for after a stall; more are lost
LET_IN_S = 5e-5  # a late loop sleeps at least this long, so that other threads can run


class Pace:
    """`late` counts the steps that began more than a step too late, `worst` is the greatest lateness (s)."""

    def __init__(self, clock: Timer) -> None:
        self._clock = clock
        self.late, self.worst = 0, 0.0
        self.begin()

    def begin(self) -> None:
        """Begin anew, after a rest."""
        self._due = self._clock.monotonic()

    def wait(self) -> None:
        """Sleep until the next step is due."""
        self._due += STEP_S
        pause = self._due - self._clock.monotonic()
        self._clock.sleep(max(pause, LET_IN_S))
        behind = self._clock.monotonic() - self._due
        self.late += behind > STEP_S
        self.worst = max(self.worst, behind)
        if pause <= 0:
            self._due = max(self._due, self._clock.monotonic() - CATCH_UP * STEP_S)
