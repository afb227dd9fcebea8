"""Who is told that where they stand has changed: one subscription a process, for all people's sockets."""

import asyncio
import logging

import msgspec
import redis.asyncio as aioredis
from django.conf import settings
from redis.exceptions import RedisError

from robots import bus
from robots.messages import decode_standing

log = logging.getLogger(__name__)
AGAIN_S = 0.5


class Bell:
    """One person's socket: rung when one of its queues, or the person's own standing, changed."""

    def __init__(self, user: int) -> None:
        self.user = user
        self.queues: frozenset[int] | None = None  # not known yet: any may be its own
        self.rung = asyncio.Event()


class Bells:
    """The bells of one event loop."""

    def __init__(self) -> None:
        self.link = False
        self._bells: set[Bell] = set()
        self._task: asyncio.Task[None] | None = None

    def attach(self, bell: Bell) -> None:
        """Add a bell; the first one starts the reader."""
        self._bells.add(bell)
        if self._task is None or self._task.done():
            self._task = asyncio.create_task(self._read())

    def detach(self, bell: Bell) -> None:
        """Remove a bell; without any the reader ends."""
        self._bells.discard(bell)
        if not self._bells and self._task is not None:
            self._task.cancel()
            self._task, self.link = None, False

    def __len__(self) -> int:
        return len(self._bells)

    async def _read(self) -> None:
        while True:
            try:
                await self._read_once()
            except (RedisError, OSError, ValueError) as error:
                log.debug("bells: %s", error)
            self.link = False
            await asyncio.sleep(AGAIN_S)

    async def _read_once(self) -> None:
        connection = aioredis.Redis.from_url(
            settings.REDIS_URL, socket_timeout=None, socket_connect_timeout=0.5, retry=None
        )
        try:
            pubsub = connection.pubsub(ignore_subscribe_messages=True)
            await pubsub.subscribe(bus.people_channel())
            self.link = True
            self._ring_all()  # what was told meanwhile was lost
            while True:
                message = await pubsub.get_message(timeout=30.0)
                if message is not None:
                    self._ring(message["data"])
        finally:
            await connection.aclose()

    def _ring_all(self) -> None:
        for bell in self._bells:
            bell.rung.set()

    def _ring(self, data: bytes) -> None:
        try:
            told = decode_standing(data)
        except msgspec.MsgspecError as error:
            log.warning("what was told to people was not understood: %s", error)
            return
        for bell in self._bells:
            if told.user == bell.user or bell.queues is None or told.queue in bell.queues:
                bell.rung.set()


_bells: dict[int, Bells] = {}


def bells() -> Bells:
    """Return the bells of the running event loop."""
    return _bells.setdefault(id(asyncio.get_running_loop()), Bells())
