"""What the sockets of one event loop share: one object of each kind, made when the first socket is served."""

import asyncio
from functools import cache

from portal.live.audience import Audience
from portal.live.hub import Hub
from portal.live.previews import Previewer
from portal.live.sessions import SessionWatch
from portal.live.shared import Snapshots
from portal.live.subscriptions import Subscriptions


class LoopState:
    """The shared objects of one event loop."""

    def __init__(self) -> None:
        self.audience, self.sessions = Audience(), SessionWatch()
        self.hub = Hub(self.audience, self.sessions)
        self.snapshots, self.previews, self.people = Snapshots(), Previewer(), Subscriptions()


@cache
def _made(loop: asyncio.AbstractEventLoop) -> LoopState:
    return LoopState()


def of_loop() -> LoopState:
    """Return the shared objects of the running event loop."""
    return _made(asyncio.get_running_loop())
