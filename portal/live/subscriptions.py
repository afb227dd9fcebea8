"""Tells people's sockets that their places changed: one Redis subscription per process for all of them."""

import asyncio
import logging
from typing import Any

import msgspec

from portal.live.store import Reader
from robots import bus
from robots.kit.packets import StandingChanged, decode_standing

log = logging.getLogger(__name__)


class Subscriber:
    """One person's socket; `changed` is set when one of its queues or the person's own places changed."""

    def __init__(self, user: int) -> None:
        self.changed = asyncio.Event()
        self._user = user
        self._queues: frozenset[int] | None = None  # not known yet: each may be its own
        self._told: set[int] = set()  # queues that changed since the places began to be read

    def begin_reading(self) -> None:
        """Note that the places are read now: later changes may be missing in them."""
        self.changed.clear()
        self._told.clear()

    def end_reading(self, queues: frozenset[int]) -> None:
        """Note in which queues the person is. One that changed while the places were read is read again."""
        self._queues = queues
        if self._told & queues:
            self.changed.set()

    def hear(self, change: StandingChanged) -> None:
        """Take a message that may concern this person."""
        self._told.add(change.queue)
        if change.user == self._user or self._queues is None or change.queue in self._queues:
            self.changed.set()


class Subscriptions:
    """The subscribers of one event loop. `link` is True while Redis is connected."""

    def __init__(self) -> None:
        self.link = False
        self._subscribers: dict[Subscriber, None] = {}  # in the order in which they came
        self._reader = Reader(bus.people_channel(), self._take, self._lose, self._prepare)
        self._task: asyncio.Task[None] | None = None

    def attach(self, subscriber: Subscriber) -> None:
        """Add a subscriber; the first one starts the task that reads."""
        self._subscribers[subscriber] = None
        if self._task is None or self._task.done():
            self._task = asyncio.create_task(self._reader.run())

    def detach(self, subscriber: Subscriber) -> None:
        """Remove a subscriber; without any the task ends."""
        self._subscribers.pop(subscriber, None)
        if not self._subscribers and self._task is not None:
            self._task.cancel()
            self._task, self.link = None, False

    def __len__(self) -> int:
        return len(self._subscribers)

    def _lose(self) -> None:
        if self.link:
            self.link = False
            self._wake_all()  # each socket looks at the database by itself from now on

    async def _prepare(self) -> None:
        self.link = True
        self._wake_all()  # messages sent meanwhile were lost

    def _take(self, message: dict[str, Any]) -> None:
        if message["type"] == "message":
            self._wake(message["data"])

    def _wake_all(self) -> None:
        for subscriber in self._subscribers:
            subscriber.changed.set()

    def _wake(self, data: bytes) -> None:
        try:
            told = decode_standing(data)
        except msgspec.MsgspecError as error:
            log.warning("a message on the channel of people was not understood: %s", error)
            return
        for subscriber in self._subscribers:
            subscriber.hear(told)
