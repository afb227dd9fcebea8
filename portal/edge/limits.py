"""Limits of each network address in this process: open items at once, and a token bucket for rates."""

from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from portal.edge.addresses import network_of
from robots.kit.clock import SYSTEM

MANY = 1000  # addresses that are remembered before those with full buckets are forgotten


class AddressCount:
    """Counts open items of each network address (IPv6: its /64), up to `most` each."""

    def __init__(self, most: int) -> None:
        self.most = most
        self._open: Counter[str] = Counter()

    def enter(self, address: str) -> bool:
        """Add one. Return False if the limit is reached."""
        network = network_of(address)
        if self._open[network] >= self.most:
            return False
        self._open[network] += 1
        return True

    def leave(self, address: str) -> None:
        """Remove one."""
        network = network_of(address)
        self._open[network] -= 1
        if self._open[network] <= 0:
            del self._open[network]

    @contextmanager
    def one(self, address: str) -> Iterator[bool]:
        """Add one for the duration of a `with` block; the value says whether there was room."""
        entered = self.enter(address)
        try:
            yield entered
        finally:
            if entered:
                self.leave(address)

    def open(self, address: str) -> int:
        """Return how many are open."""
        return self._open.get(network_of(address), 0)


class Bucket:
    """A token bucket: `rate` tokens come a second, up to `burst`; it is full at the beginning."""

    __slots__ = ("_at", "_burst", "_left", "_rate")

    def __init__(self, rate: float, burst: float) -> None:
        self._rate, self._burst, self._left, self._at = rate, burst, burst, 0.0

    def take(self, now: float) -> bool:
        """Take a token at that time (s). Return False if there is none; a fraction of one is lost then."""
        left = self._has(now) - 1.0
        self._left, self._at = max(0.0, left), now
        return left >= 0.0

    def full(self, now: float) -> bool:
        """Return whether all tokens are there."""
        return self._has(now) >= self._burst

    def _has(self, now: float) -> float:
        return min(self._burst, self._left + (now - self._at) * self._rate)


class AddressRate:
    """A bucket for each network address (IPv6: its /64)."""

    def __init__(self, rate: float, burst: float, clock: Callable[[], float] = SYSTEM.awake) -> None:
        self._rate, self._burst, self._clock = rate, burst, clock
        self._buckets: dict[str, Bucket] = {}

    def take(self, address: str) -> bool:
        """Take a token of the address. Return False if there is none."""
        network, now = network_of(address), self._clock()
        if network not in self._buckets:
            if len(self._buckets) >= MANY:
                self._buckets = {one: bucket for one, bucket in self._buckets.items() if not bucket.full(now)}
            self._buckets[network] = Bucket(self._rate, self._burst)
        return self._buckets[network].take(now)
