"""How late threads come back from their waits: the busy machine, as a fault with a seed."""

import random
from collections.abc import Mapping


class Delays:
    """Says how late (s) the wait with a number ends; what it said is `given`, by the number of the wait."""

    def __init__(self, seed: int, share: float, mean_s: float, longest_s: float) -> None:
        self._dice = random.Random(f"delays {seed}")
        self._share, self._mean_s, self._longest_s = share, mean_s, longest_s
        self.given: dict[int, float] = {}

    def of(self, wait: int) -> float:
        if self._dice.random() >= self._share:
            return 0.0
        late_s = self.given[wait] = min(self._dice.expovariate(1 / self._mean_s), self._longest_s)
        return late_s


class These(Delays):
    """Exactly these delays (s), by the number of the wait."""

    def __init__(self, given: Mapping[int, float]) -> None:
        self.given = dict(given)

    def of(self, wait: int) -> float:
        return self.given.get(wait, 0.0)


NONE = These({})
