"""Few pages are rendered at once, so that threads leave the interpreter to commands and stops; addresses take turns."""

import asyncio
from collections import OrderedDict, deque
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from django.conf import settings
from django.core.handlers.asgi import ASGIHandler
from django.http import HttpRequest
from django.http.response import HttpResponseBase

from portal.limits.addresses import network_of


class FairSemaphore:
    """Lets `most` in at a time, in one event loop; who waits comes in by turns of the network addresses."""

    def __init__(self, most: int) -> None:
        self._free = most
        self._waiting: OrderedDict[str, deque[asyncio.Future[None]]] = OrderedDict()  # the next address is first

    @asynccontextmanager
    async def room(self, address: str) -> AsyncIterator[None]:
        """Wait for room, and leave it at the end of the `async with` block."""
        await self._enter(network_of(address))
        try:
            yield
        finally:
            self._leave()

    async def _enter(self, network: str) -> None:
        if self._free:
            self._free -= 1
            return
        entry: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self._waiting.setdefault(network, deque()).append(entry)
        try:
            await entry
        except asyncio.CancelledError:
            if not entry.cancelled():  # it was let in at the same moment
                self._leave()
            raise

    def _leave(self) -> None:
        while self._waiting:
            network, entries = self._waiting.popitem(last=False)
            entry = entries.popleft()
            if entries:
                self._waiting[network] = entries
            if not entry.done():
                entry.set_result(None)
                return
        self._free += 1


class FewPages(ASGIHandler):
    """Django's handler, which renders at most `LIMITS["PAGES"]` pages at a time.

    Bodies are received before, and what a page streams is sent afterwards; neither is counted.
    """

    def __init__(self) -> None:
        super().__init__()
        self._semaphore = FairSemaphore(settings.LIMITS["PAGES"])

    async def get_response_async(self, request: HttpRequest) -> HttpResponseBase:
        """Render a page when there is room."""
        async with self._semaphore.room(request.META["REMOTE_ADDR"]):
            return await super().get_response_async(request)
