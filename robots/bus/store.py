"""This process's connection to Redis, for short calls and for pub/sub."""

from collections import Counter
from functools import cache

import redis
from django.conf import settings

failures: Counter[str] = Counter()
OPEN_S = 3.0  # for a connection for pub/sub, with all that Redis has to answer until it is open

_given: list[redis.Redis] = []  # what this process speaks through instead of a server, if it was given something


def speak_through(store: redis.Redis | None) -> None:
    """Speak through this store from now on, for short calls and for pub/sub; None: through the server again."""
    _given[:] = [] if store is None else [store]


def connection() -> redis.Redis:
    """Return this process's connection pool for short calls."""
    return _given[0] if _given else _pool()


@cache
def _pool() -> redis.Redis:
    return redis.Redis.from_url(
        settings.REDIS_URL,
        socket_timeout=settings.REDIS_TIMEOUT_S,
        socket_connect_timeout=settings.REDIS_TIMEOUT_S,
        retry=None,
    )


def listener() -> redis.Redis:
    """Return a connection for pub/sub: opened within `OPEN_S`; who listens finds out by pings that it is gone."""
    if _given:
        return _given[0]
    return redis.Redis.from_url(settings.REDIS_URL, socket_timeout=OPEN_S, socket_connect_timeout=1.0, retry=None)


def alive() -> bool:
    """Return whether Redis answers."""
    try:
        return bool(connection().ping())
    except (redis.RedisError, OSError):
        return False
