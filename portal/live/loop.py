"""The objects that the sockets of one event loop share; they are made when the first socket is served."""

import asyncio
from collections.abc import Callable
from functools import cache
from typing import TypeVar

from portal.live.audience import Audience
from portal.live.hub import Hub
from portal.live.previews import Previewer
from portal.live.sessions import SessionWatch
from portal.live.shared import Snapshots
from portal.live.subscriptions import Subscriptions

T = TypeVar("T")


def once_per_loop(make: Callable[[], T]) -> Callable[[], T]:
    """Return a function that returns what `make` returns, in each event loop always the same object."""

    @cache
    def made(loop: asyncio.AbstractEventLoop) -> T:
        return make()

    return lambda: made(asyncio.get_running_loop())


class LoopState:
    """The shared objects of one event loop."""

    def __init__(self) -> None:
        self.audience, self.sessions = Audience(), SessionWatch()
        self.hub = Hub(self.audience, self.sessions)
        self.snapshots, self.previews, self.people = Snapshots(), Previewer(), Subscriptions()


of_loop = once_per_loop(LoopState)  # returns the shared objects of the running event loop
