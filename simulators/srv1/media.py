"""Media that carry bytes between owner and rover in place of Wi-Fi: the packet radio of section 5.4, the Internet."""

from collections.abc import Callable
from random import Random

from robots.kit.description import load

BITS_A_BYTE = 8


class Internet:
    """A `link.Medium` with random delays: each piece takes its own time, and none overtakes another.

    `seed`: of the delays. Not for several threads.
    """

    def __init__(self, seed: int) -> None:
        self._least, self._most = (float(seconds) for seconds in load("srv1")["line"]["internet_s"])
        self._dice, self._last = Random(seed), 0.0

    def reaches(self, farther: float) -> bool:
        """See `link.Medium`."""
        return True

    def arrival(self, now: float, size: int) -> float:
        """See `link.Medium`; either way."""
        self._last = max(self._last, now + self._dice.uniform(self._least, self._most))
        return self._last


class Radio:
    """A `link.Medium` that is slow, half duplex, and of a short reach.

    `distance`: of rover and station (m). Not for several threads.
    """

    def __init__(self, distance: Callable[[], float]) -> None:
        line = load("srv1")["line"]
        self._byte_s = float(BITS_A_BYTE / line["radio_bit_s"])
        self._half_cycle_s = float(line["cycle_s"] / 2)
        self._reach = float(line["radio_m"])
        self._distance, self._free = distance, 0.0

    def reaches(self, farther: float) -> bool:
        """See `link.Medium`."""
        return self._distance() + farther <= self._reach

    def arrival(self, now: float, size: int) -> float:
        """See `link.Medium`; bytes wait while others are sent."""
        self._free = max(self._free, now) + size * self._byte_s
        return self._free + self._half_cycle_s
