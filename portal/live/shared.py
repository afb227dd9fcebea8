"""The snapshot that everybody who is not signed in gets: read once for all who ask at about the same time."""

import asyncio
import json
from collections.abc import Awaitable, Callable

from django.contrib.auth.models import AnonymousUser

from portal.live.snapshot import snapshot
from portal.live.threads import ANYBODY
from robots.clock import SYSTEM


class Shared:
    """An answer that is worked out for many at once, and never from before they asked."""

    def __init__(self, work: Callable[[], Awaitable[str]]) -> None:
        self._work = work
        self._running: asyncio.Task[str] | None = None
        self._next: asyncio.Task[str] | None = None

    async def ask(self) -> str:
        """Return an answer whose work begins after this call. Raises what the work raises."""
        if self._next is None:
            self._next = asyncio.create_task(self._after(self._running))
            self._next.add_done_callback(lambda task: task.cancelled() or task.exception())  # nobody may be left to ask
        return await asyncio.shield(self._next)

    async def _after(self, before: asyncio.Task[str] | None) -> str:
        if before is not None:
            await asyncio.wait([before])
        self._running, self._next = self._next, None
        return await self._work()

    def idle(self) -> bool:
        """Return whether nobody waits for an answer."""
        return self._next is None and (self._running is None or self._running.done())


class Snapshots:
    """The snapshots of one event loop for people who are not signed in, one for each robot."""

    def __init__(self) -> None:
        self._of: dict[str, Shared] = {}

    async def ask(self, slug: str, link: Callable[[], bool]) -> str:
        """Return the snapshot as JSON. Raises django.db.Error and Robot.DoesNotExist."""

        async def work() -> str:
            shown = await ANYBODY.orm(snapshot)(slug, AnonymousUser(), SYSTEM.now(), link())
            return json.dumps(shown)

        shared = self._of.setdefault(slug, Shared(work))
        try:
            return await shared.ask()
        finally:
            if shared.idle() and self._of.get(slug) is shared:
                del self._of[slug]


_of_loop: dict[int, Snapshots] = {}


def snapshots() -> Snapshots:
    """Return the shared snapshots of the running event loop."""
    return _of_loop.setdefault(id(asyncio.get_running_loop()), Snapshots())
