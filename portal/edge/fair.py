"""A semaphore whose waiting network addresses take turns."""

import asyncio
from collections import OrderedDict, deque

from portal.edge.addresses import network_of


class FairSemaphore:
    """Lets `most` in at a time, in one event loop; who waits comes in by turns of the network addresses."""

    def __init__(self, most: int) -> None:
        self._free = most
        self._waiting: OrderedDict[str, deque[asyncio.Future[None]]] = OrderedDict()  # the next network is first

    async def acquire(self, address: str) -> "Room":
        """Wait for room and return it; the caller leaves it."""
        if self._free:
            self._free -= 1
            return Room(self)
        entry: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self._waiting.setdefault(network_of(address), deque()).append(entry)
        try:
            await entry
        except asyncio.CancelledError:
            if not entry.cancelled():  # it was let in at the same moment
                self.release()
            raise
        return Room(self)

    def release(self) -> None:
        """Let the next one in."""
        while self._waiting:
            network, entries = self._waiting.popitem(last=False)
            entry = entries.popleft()
            if entries:
                self._waiting[network] = entries
            if not entry.done():
                entry.set_result(None)
                return
        self._free += 1


class Room:
    """The room of one page."""

    def __init__(self, semaphore: FairSemaphore) -> None:
        self._semaphore: FairSemaphore | None = semaphore

    def leave(self) -> None:
        """Leave it to the next page; a second time does nothing."""
        if self._semaphore is not None:
            self._semaphore.release()
            self._semaphore = None
