"""Counts open connections, requests and sockets of each network address in this process."""

from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager

from portal.edge.addresses import network_of


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
