"""The connection to Redis over which the sockets of a process receive published messages."""

import asyncio
import logging
from collections.abc import Awaitable, Callable
from math import inf
from typing import Any

import redis.asyncio as aioredis
from django.conf import settings
from redis.exceptions import RedisError

from robots.bus.reader import PING_S, SILENT_S
from robots.kit.clock import SYSTEM

log = logging.getLogger(__name__)
AGAIN_S = 0.3  # between two attempts to open a connection

_openers: list[Callable[[], aioredis.Redis]] = []  # one that replaces the server, or none


def speak_through(opener: Callable[[], aioredis.Redis] | None) -> None:
    """Open connections by this function from now on; None: to the server again."""
    _openers[:] = [] if opener is None else [opener]


def listener() -> aioredis.Redis:
    """Return a new connection without a time limit; pings show whether it is still there."""
    if _openers:
        return _openers[0]()
    return aioredis.Redis.from_url(settings.REDIS_URL, socket_timeout=None, socket_connect_timeout=0.5, retry=None)


async def _nothing() -> None:
    pass


class Reader:
    """Reads published messages, over one connection that is opened again whenever it ends or is silent.

    `take` is given each message of Redis, also answers to pings and subscriptions; one that cannot be handled changes
    nothing for those that follow. `prepare` is awaited when the connection has been opened, with `channel` subscribed,
    and before the first ping, whose answer follows all that it asks for. `lose` is called after each end.
    """

    def __init__(
        self, channel: str, take: Callable[[dict[str, Any]], None], lose: Callable[[], None],
        prepare: Callable[[], Awaitable[None]] = _nothing,
    ) -> None:  # fmt: skip
        self._channel, self._take, self._lose, self._prepare = channel, take, lose, prepare
        self.connection: aioredis.Redis | None = None  # for short calls; None while there is none
        self.pubsub: Any = None

    async def run(self) -> None:
        """Read until it is cancelled."""
        while True:
            try:
                await self._read()
            except (RedisError, OSError) as error:
                log.debug("the connection to Redis: %s", error)
            except Exception:  # every socket of this process depends on this loop
                log.exception("the connection to Redis ended")
            self._lose()
            await asyncio.sleep(AGAIN_S)

    async def _read(self) -> None:
        connection = listener()
        try:
            pubsub = connection.pubsub()
            async with asyncio.timeout(SILENT_S):
                await pubsub.subscribe(self._channel)
            # not before it is open: a call while it opens would open a second one, which nobody reads
            self.connection, self.pubsub = connection, pubsub
            await self._prepare()
            heard, asked = SYSTEM.awake(), -inf
            while (now := SYSTEM.awake()) - heard < SILENT_S:
                if now - asked >= PING_S:
                    asked = now
                    await pubsub.ping()
                message = await pubsub.get_message(timeout=min(PING_S, heard + SILENT_S - now))
                if message is not None:
                    heard = SYSTEM.awake()
                    self._handle(message)
        finally:  # or a later call would open the old connection again
            self.connection = self.pubsub = None
            await connection.aclose()

    def _handle(self, message: dict[str, Any]) -> None:
        try:
            self._take(message)
        except Exception:
            log.exception("a message on the bus could not be handled: %r", message.get("channel"))
