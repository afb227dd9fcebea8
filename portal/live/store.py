"""The connection to Redis over which the sockets of a process hear what is published."""

from collections.abc import Callable

import redis.asyncio as aioredis
from django.conf import settings

_given: list[Callable[[], aioredis.Redis]] = []  # what opens connections instead, if this process was given something


def speak_through(opened: Callable[[], aioredis.Redis] | None) -> None:
    """Have connections opened by this from now on; None: to the server again."""
    _given[:] = [] if opened is None else [opened]


def listener() -> aioredis.Redis:
    """Return a new connection; who listens finds out by pings that it is gone."""
    if _given:
        return _given[0]()
    return aioredis.Redis.from_url(settings.REDIS_URL, socket_timeout=None, socket_connect_timeout=0.5, retry=None)
