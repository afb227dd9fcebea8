"""The public part of a robot's snapshot: read once for all who ask at about the same time.

Strangers get it as it is; people who are signed in get their own part added. An operator does not wait for it.
"""

import asyncio
import json
from collections.abc import Awaitable, Callable
from typing import Any, Generic, NamedTuple, TypeVar

from django.contrib.auth.models import AnonymousUser

from portal.live.snapshot import cheered_grant, snapshot
from portal.live.threads import EVERYBODY
from robots.kit.clock import SYSTEM

T = TypeVar("T")


class SharedSnapshot(NamedTuple):
    """A snapshot as JSON: without a person, and of somebody who is not signed in; the grant in which one may cheer."""

    public: str
    of_strangers: str
    cheers: int = 0


def with_person(public: str, me: dict[str, Any]) -> str:
    """Return the public part of a snapshot with a person's own part."""
    return f'{public[:-1]}, "me": {json.dumps(me)}}}'


class Shared(Generic[T]):
    """The result of a work that is shared by all who ask while it waits to begin."""

    def __init__(self, work: Callable[[], Awaitable[T]]) -> None:
        self._work = work
        self._running: asyncio.Task[T] | None = None
        self._next: asyncio.Task[T] | None = None

    async def ask(self) -> T:
        """Return an answer whose work begins after this call. Raises what the work raises."""
        if self._next is None:
            self._next = asyncio.create_task(self._after(self._running))
            self._next.add_done_callback(lambda task: task.cancelled() or task.exception())  # nobody may be left to ask
        return await asyncio.shield(self._next)

    async def _after(self, before: asyncio.Task[T] | None) -> T:
        if before is not None:
            await asyncio.wait([before])
        self._running, self._next = self._next, None
        return await self._work()

    def idle(self) -> bool:
        """Return whether nobody waits for an answer."""
        return self._next is None and (self._running is None or self._running.done())


class Snapshots:
    """The snapshots of one event loop, one for each robot."""

    def __init__(self) -> None:
        self._of: dict[str, Shared[SharedSnapshot]] = {}

    async def ask(self, slug: str, link: Callable[[], bool]) -> SharedSnapshot:
        """Return the snapshot. Raises django.db.Error and Robot.DoesNotExist."""

        async def work() -> SharedSnapshot:
            shown = await EVERYBODY.orm(snapshot)(slug, AnonymousUser(), SYSTEM.now(), link())
            me = shown.pop("me")
            public = json.dumps(shown)
            return SharedSnapshot(public, with_person(public, me), cheered_grant(shown))

        shared = self._of.setdefault(slug, Shared(work))
        try:
            return await shared.ask()
        finally:
            if shared.idle() and self._of.get(slug) is shared:
                del self._of[slug]
