"""Few pages are rendered at once, so that threads leave the interpreter to commands and stops; addresses take turns."""

import asyncio
from functools import partial

from django.conf import settings
from django.core.handlers.asgi import ASGIHandler
from django.http import HttpRequest
from django.http.response import HttpResponseBase

from portal.edge.fair import FairSemaphore


class FewPages(ASGIHandler):
    """Django's handler, which renders at most `LIMITS["PAGES"]` pages at a time.

    Bodies are received before, and what a page streams is sent afterwards; neither is counted.
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
