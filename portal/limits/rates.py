"""How many messages come from each network address, over all its sockets in this process."""

import time
from collections.abc import Callable

from portal.limits.addresses import network_of

MANY = 1000  # addresses that are remembered before those that are calm are forgotten


class AddressRate:
    """A bucket of tokens for each network address (IPv6: its /64): `rate` a second, `burst` at once."""

    def __init__(self, rate: float, burst: float, clock: Callable[[], float] = time.monotonic) -> None:
        self.rate, self.burst, self._clock = rate, burst, clock
        self._left: dict[str, tuple[float, float]] = {}  # tokens, and when that was

    def take(self, address: str) -> bool:
        """Take a token. Return False if there is none."""
        network, now = network_of(address), self._clock()
        left, at = self._left.get(network, (self.burst, now))
        left = min(self.burst, left + (now - at) * self.rate)
        if network not in self._left and len(self._left) >= MANY:
            self._forget_calm(now)
        self._left[network] = (max(0.0, left - 1.0), now)
        return left >= 1.0

    def _forget_calm(self, now: float) -> None:
        full = [one for one, (left, at) in self._left.items() if left + (now - at) * self.rate >= self.burst]
        for network in full:
            del self._left[network]
