"""Slows down work that can wait if the machine is too busy: live pictures first.

A loop that sleeps measures how late it wakes up, and the mean of the last seconds decides. A load average tells how
busy the machine is; lateness tells the effect on this process.
"""

import math
from collections import deque

WINDOW_S = 2.0
CALM_S = 3.0  # the machine must be calm this long before a step is taken back
# (least mean lateness in s, pictures a second)
STEPS = ((0.0, math.inf), (0.04, 5.0), (0.10, 2.0), (0.25, 0.0))
ONLY_STILLS = len(STEPS) - 1


class Brownout:
    """The present level of slowing down, from 0 (none) to `ONLY_STILLS`."""

    def __init__(self) -> None:
        self.level = 0
        self._felt: deque[tuple[float, float]] = deque()
        self._calm_since = 0.0

    def feel(self, late_s: float, now: float) -> None:
        """Note that a loop woke `late_s` (s) too late at the time `now` (s, monotonic)."""
        self._felt.append((now, max(0.0, late_s)))
        while now - self._felt[0][0] > WINDOW_S:
            self._felt.popleft()
        mean = sum(late for _, late in self._felt) / len(self._felt)
        reached = max(level for level, (late, _) in enumerate(STEPS) if mean >= late)
        if reached > self.level:
            self.level, self._calm_since = reached, now
        elif mean >= STEPS[self.level][0] / 2:
            self._calm_since = now
        elif self.level and now - self._calm_since >= CALM_S:
            self.level, self._calm_since = self.level - 1, now

    def every_s(self, usual_s: float) -> float:
        """Return the time between two pictures (s), usually `usual_s`; infinite if only stills are sent."""
        rate = STEPS[self.level][1]
        return max(usual_s, 1.0 / rate) if rate else math.inf
