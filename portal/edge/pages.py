"""Limits how many pages are rendered at once, so that commands and stops get the interpreter; addresses take turns."""

import asyncio
from collections import OrderedDict, deque
from functools import partial

from django.conf import settings
from django.core.handlers.asgi import ASGIHandler
from django.http import HttpRequest
from django.http.response import HttpResponseBase

from portal.edge.addresses import network_of


class FewPages(ASGIHandler):
    """Django's handler, which renders at most `LIMITS["PAGES"]` pages at a time.

    Bodies are received before, and streams are sent afterwards; neither is counted.
    """

    def __init__(self) -> None:
        super().__init__()
        self._semaphore = FairSemaphore(settings.LIMITS["PAGES"])

    async def get_response_async(self, request: HttpRequest) -> HttpResponseBase:
        """Render a page when there is room."""
        room = await self._semaphore.acquire(request.META.get("REMOTE_ADDR", ""))
        request.leave_room = partial(asyncio.get_running_loop().call_soon_threadsafe, room.leave)  # type: ignore[attr-defined]
        try:
            return await super().get_response_async(request)
        finally:
            room.leave()


def leave_room(request: HttpRequest) -> None:
    """Let the next page be rendered: this one waits for a robot now. May be called in any thread."""
    leave = getattr(request, "leave_room", None)  # absent outside `FewPages`
    if leave is not None:
        leave()


class FairSemaphore:
    """A semaphore of `most`, in one event loop; the network addresses that wait take turns."""

    def __init__(self, most: int) -> None:
        self._free = most
        self._waiting: OrderedDict[str, deque[asyncio.Future[None]]] = OrderedDict()  # the next network is first

    async def acquire(self, address: str) -> "Room":
        """Wait for room and return it; the caller has to leave it."""
        if self._free:
            self._free -= 1
            return Room(self)
        entry: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self._waiting.setdefault(network_of(address), deque()).append(entry)
        try:
            await entry
        except asyncio.CancelledError:
            if not entry.cancelled():  # it was given room at the same moment
                self.release()
            raise
        return Room(self)

    def release(self) -> None:
        """Give the room to the page that is next."""
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
    """The room of one page that is being rendered."""

    def __init__(self, semaphore: FairSemaphore) -> None:
        self._semaphore: FairSemaphore | None = semaphore

    def leave(self) -> None:
        """Give the room to the next page; a second call does nothing."""
        if self._semaphore is not None:
            self._semaphore.release()
            self._semaphore = None
