"""Reads published messages in one thread: pings tell whether the connection is still there."""

import contextlib
from collections.abc import Iterable

import redis

from robots.bus import store
from robots.kit.clock import Timer

PING_S, SILENT_S = 2.0, 7.0  # Redis answers each ping; after this silence it is taken for gone


class Reader:
    """A connection for pub/sub, opened with the first channel; after an error it is of no use any more."""

    def __init__(self, clock: Timer) -> None:
        self._clock = clock
        self._pubsub = store.listener().pubsub(ignore_subscribe_messages=True)
        self.channels: set[str] = set()
        self._heard_at = self._asked_at = 0.0

    def subscribe(self, channels: Iterable[str]) -> None:
        """Hear these channels too. Raises redis.RedisError, OSError."""
        new = set(channels) - self.channels
        if not new:
            return
        if not self.channels:
            self._heard_at = self._asked_at = self._clock.monotonic()
        self.channels |= new
        self._pubsub.subscribe(*new)

    def unsubscribe(self, channels: Iterable[str]) -> None:
        """Hear these channels no more. Raises redis.RedisError, OSError."""
        old = self.channels.intersection(channels)
        if old:  # none would mean all
            self.channels -= old
            self._pubsub.unsubscribe(*old)

    def read(self, within_s: float) -> tuple[str, bytes] | None:
        """Return channel and data of the next message; None if none came within this time, or an answer to a ping.

        Raises redis.RedisError, OSError, also after a silence.
        """
        if self._clock.monotonic() - self._asked_at >= PING_S:
            self._asked_at = self._clock.monotonic()
            self._pubsub.ping()
        message = self._pubsub.get_message(timeout=within_s)
        if message is not None:
            self._heard_at = self._clock.monotonic()
        elif self._clock.monotonic() - self._heard_at >= SILENT_S:
            raise redis.ConnectionError("Redis is silent")
        if message is None or message["type"] != "message":
            return None
        return message["channel"].decode(), message["data"]

    def close(self) -> None:
        """Close the connection."""
        with contextlib.suppress(OSError, redis.RedisError):
            self._pubsub.close()
