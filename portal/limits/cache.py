"""The cache that all web processes share, for limits of attempts: Redis, and this process's memory while it is away.

Limits then still hold, for each process by itself; no page fails for want of Redis.
"""

import contextlib
import json
import time
from collections.abc import Callable
from typing import Any

from django.core.cache.backends.base import DEFAULT_TIMEOUT, BaseCache
from django.core.cache.backends.locmem import LocMemCache
from django.core.cache.backends.redis import RedisCache
from redis.exceptions import RedisError

AGAIN_S = 2.0  # between two tries of a Redis that is away


class Plain:
    """Values as JSON: what stands in Redis is read, never run."""

    def dumps(self, value: Any) -> bytes | int:
        """Return the value as Redis keeps it; integers as such, so that they can be counted up."""
        return value if type(value) is int else json.dumps(value).encode()

    def loads(self, data: bytes) -> Any:
        """Return the value again."""
        return json.loads(data)


class SharedCache(BaseCache):
    """Django's cache over Redis, which falls back to memory and comes back by itself."""

    def __init__(self, location: str, params: dict[str, Any]) -> None:
        super().__init__(params)
        self._shared = RedisCache(location, params)
        self._own = LocMemCache("limits", {"OPTIONS": {"MAX_ENTRIES": 100_000}})
        self._away_until = 0.0

    def _do(self, verb: str, *args: Any, **kwargs: Any) -> Any:
        if time.monotonic() >= self._away_until:
            try:
                call: Callable[..., Any] = getattr(self._shared, verb)
                return call(*args, **kwargs)
            except (RedisError, OSError):
                self._away_until = time.monotonic() + AGAIN_S
        return getattr(self._own, verb)(*args, **kwargs)

    def add(self, key: str, value: Any, timeout: Any = DEFAULT_TIMEOUT, version: int | None = None) -> bool:
        """Set a value that is not there yet; tell whether it was not."""
        return bool(self._do("add", key, value, timeout, version))

    def get(self, key: str, default: Any = None, version: int | None = None) -> Any:
        """Return a value."""
        return self._do("get", key, default, version)

    def set(self, key: str, value: Any, timeout: Any = DEFAULT_TIMEOUT, version: int | None = None) -> None:
        """Keep a value."""
        self._do("set", key, value, timeout, version)

    def touch(self, key: str, timeout: Any = DEFAULT_TIMEOUT, version: int | None = None) -> bool:
        """Keep a value for longer."""
        return bool(self._do("touch", key, timeout, version))

    def delete(self, key: str, version: int | None = None) -> bool:
        """Forget a value."""
        return bool(self._do("delete", key, version))

    def incr(self, key: str, delta: int = 1, version: int | None = None) -> int:
        """Count up; raises ValueError where nothing is kept."""
        return int(self._do("incr", key, delta, version))

    def clear(self) -> None:
        """Forget what was counted, and leave all else in that Redis as it is."""
        self._own.clear()
        with contextlib.suppress(RedisError, OSError):
            client = self._shared._cache.get_client(write=True)
            for key in client.scan_iter(match=f"{self._shared.key_prefix}:*", count=1000):
                client.unlink(key)
