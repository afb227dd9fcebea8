"""The cache for limits of attempts: Redis for all web processes, or memory while Redis is away.

Without Redis each process keeps the limits by itself; no page fails.
"""

import contextlib
import json
from collections.abc import Callable
from typing import Any, ClassVar

from django.core.cache.backends.base import DEFAULT_TIMEOUT, BaseCache
from django.core.cache.backends.locmem import LocMemCache
from django.core.cache.backends.redis import RedisCache
from redis.exceptions import RedisError

from robots.kit.clock import SYSTEM

AGAIN_S = 2.0  # between two attempts while Redis is away
TOMBSTONES = 10_000  # at most
TOMBSTONE_S = 10.0  # the longest life of a lock that a counting request sets and deletes


class Plain:
    """Serialises values as JSON, so that data from Redis is never executed."""

    def dumps(self, value: Any) -> bytes | int:
        """Return the stored form of a value; integers stay integers, so that Redis can count."""
        return value if type(value) is int else json.dumps(value).encode()

    def loads(self, data: bytes) -> Any:
        """Return the value of a stored form."""
        return json.loads(data)


class SharedCache(BaseCache):
    """Django's cache in Redis, which uses memory while Redis is away and returns by itself.

    A key that was deleted meanwhile leaves a tombstone, and is deleted in Redis as soon as Redis is back: a lock that
    stayed would refuse everybody who is counted under it.
    """

    _tombstones: ClassVar[dict[tuple[str, int | None], float]] = {}  # by key and version: since when

    def __init__(self, location: str, params: dict[str, Any]) -> None:
        super().__init__(params)
        self._shared = RedisCache(location, params)
        self._own = LocMemCache("limits", {"OPTIONS": {"MAX_ENTRIES": 100_000}})
        self._away_until = 0.0

    def _do(self, verb: str, *args: Any, **kwargs: Any) -> Any:
        if SYSTEM.awake() >= self._away_until:
            try:
                self._settle()
                call: Callable[..., Any] = getattr(self._shared, verb)
                return call(*args, **kwargs)
            except (RedisError, OSError):
                self._away_until = SYSTEM.awake() + AGAIN_S
        if verb == "delete" and len(self._tombstones) < TOMBSTONES:
            self._tombstones[args] = SYSTEM.awake()  # (key, version)
        return getattr(self._own, verb)(*args, **kwargs)

    def _settle(self) -> None:
        """Delete the keys of tombstones in Redis. Raises RedisError, OSError; the other tombstones stay."""
        for (key, version), since in list(self._tombstones.items()):
            if SYSTEM.awake() - since < TOMBSTONE_S:
                self._shared.delete(key, version=version)
            self._tombstones.pop((key, version), None)

    def add(self, key: str, value: Any, timeout: Any = DEFAULT_TIMEOUT, version: int | None = None) -> bool:
        """Set a value if there is none. Return whether it was set."""
        return bool(self._do("add", key, value, timeout, version))

    def get(self, key: str, default: Any = None, version: int | None = None) -> Any:
        """Return the value of a key, or `default`."""
        return self._do("get", key, default, version)

    def set(self, key: str, value: Any, timeout: Any = DEFAULT_TIMEOUT, version: int | None = None) -> None:
        """Keep a value for `timeout` (s)."""
        self._do("set", key, value, timeout, version)

    def touch(self, key: str, timeout: Any = DEFAULT_TIMEOUT, version: int | None = None) -> bool:
        """Keep a value for `timeout` (s) from now. Return whether there is one."""
        return bool(self._do("touch", key, timeout, version))

    def delete(self, key: str, version: int | None = None) -> bool:
        """Forget a key. Return whether there was a value."""
        return bool(self._do("delete", key, version))

    def incr(self, key: str, delta: int = 1, version: int | None = None) -> int:
        """Add to a number. Raises ValueError if there is none."""
        return int(self._do("incr", key, delta, version))

    def clear(self) -> None:
        """Delete the counters, and nothing else in that Redis."""
        self._own.clear()
        with contextlib.suppress(RedisError, OSError):
            client = self._shared._cache.get_client(write=True)
            for key in client.scan_iter(match=f"{self._shared.key_prefix}:*", count=1000):
                client.unlink(key)
