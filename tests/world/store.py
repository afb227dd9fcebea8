"""Redis in memory: what `robots.bus` and its like ask of it, with its outages. A contract test compares it with Redis."""

import fnmatch
import math
from collections import deque
from collections.abc import Callable
from functools import partial

import redis

from tests.world.world import World

TIMEOUT_S = 0.2  # FARHAND's for a short call
LATENCY_S = 0.0003


def as_bytes(value: object) -> bytes:
    return value if isinstance(value, bytes) else str(value).encode()


class MemoryStore:
    """A store of one world. `up` False: connections are refused; `silent`: it takes calls and does not answer."""

    def __init__(self, world: World) -> None:
        self.world, self.up, self.silent = world, True, False
        self.copies = lambda channel: 1  # how often a message arrives; 0: it is lost on its way
        self._values: dict[str, bytes | list[bytes] | dict[bytes, bytes]] = {}
        self._ends: dict[str, float] = {}  # monotonic (s)
        self.listeners: list[Listener] = []

    def restart(self) -> None:
        """Forget everything, and end every connection."""
        self._values.clear()
        self._ends.clear()
        for listener in self.listeners:
            listener.broken = True

    def ask(self) -> None:
        """Carry a call there and back. Raises redis.ConnectionError, redis.TimeoutError."""
        self.world.pause(LATENCY_S)
        if self.silent:
            self.world.pause(TIMEOUT_S)
            raise redis.TimeoutError("Timeout reading from the store")
        if not self.up:
            raise redis.ConnectionError("the store is away")

    def _live(self, key: str) -> bool:
        if self._ends.get(key, math.inf) <= self.world.monotonic():
            self._values.pop(key, None)
            self._ends.pop(key, None)
        return key in self._values

    def __getattr__(self, name: str) -> Callable:
        """Return a command of Redis, which is carried there and back; without that it is `_name`."""
        if name.startswith("_"):
            raise AttributeError(name)
        command = getattr(self, f"_{name}")

        def call(*args, **kwargs):
            self.ask()
            return command(*args, **kwargs)

        return call

    def _ping(self) -> bool:
        return True

    def _time(self) -> tuple[int, int]:
        microseconds = round(self.world.now().timestamp() * 1e6)
        return microseconds // 1_000_000, microseconds % 1_000_000

    def _exists(self, *keys: str) -> int:
        return sum(self._live(key) for key in keys)

    def _get(self, key: str) -> bytes | None:
        return self._values[key] if self._live(key) else None

    def _mget(self, *keys: str) -> list[bytes | None]:
        return [self._get(key) for key in keys]

    def _set(
        self, key: str, value: object, ex: float | None = None, nx: bool = False, px: int | None = None
    ) -> bool | None:  # fmt: skip
        if nx and self._live(key):
            return None
        self._values[key] = as_bytes(value)
        ex = px / 1000 if px is not None else ex
        self._ends[key] = math.inf if ex is None else self.world.monotonic() + ex
        return True

    def _incrby(self, key: str, amount: int) -> int:
        count = int(self._get(key) or 0) + amount
        if not self._live(key):
            self._ends[key] = math.inf
        self._values[key] = as_bytes(count)
        return count

    def _expire(self, key: str, seconds: float) -> bool:
        if self._live(key):
            self._ends[key] = self.world.monotonic() + seconds
        return key in self._values

    def _delete(self, *keys: str | bytes) -> int:
        names = [key.decode() if isinstance(key, bytes) else key for key in keys]
        return sum(self._live(name) and self._values.pop(name, None) is not None for name in names)

    def _getdel(self, key: str) -> bytes | None:
        return self._values.pop(key) if self._live(key) else None

    def _scan_iter(self, match: str = "*", count: int = 0) -> list[bytes]:
        return [key.encode() for key in list(self._values) if self._live(key) and fnmatch.fnmatchcase(key, match)]

    def _lrange(self, key: str, first: int, last: int) -> list[bytes]:
        return list(self._values[key])[first : None if last == -1 else last + 1] if self._live(key) else []

    def _rpush(self, key: str, *values: object) -> int:
        if not self._live(key):
            self._values[key] = []
        self._values[key] += map(as_bytes, values)
        return len(self._values[key])

    def _rpushx(self, key: str, *values: object) -> int:
        return self._rpush(key, *values) if self._live(key) else 0

    def _hset(self, key: str, name: str, value: object) -> int:
        if not self._live(key):
            self._values[key] = {}
        new = as_bytes(name) not in self._values[key]
        self._values[key][as_bytes(name)] = as_bytes(value)
        return int(new)

    def _hgetall(self, key: str) -> dict[bytes, bytes]:
        return dict(self._values[key]) if self._live(key) else {}

    def _hdel(self, key: str, *names: bytes) -> int:
        kept = self._values[key] if self._live(key) else {}
        found = sum(kept.pop(as_bytes(name), None) is not None for name in names)
        if not kept:
            self._values.pop(key, None)
        return found

    def _publish(self, channel: str, data: object) -> int:
        heard = [one for one in self.listeners if channel in one.channels and not one.broken]
        for one in heard:
            message = {"type": "message", "pattern": None, "channel": channel.encode(), "data": as_bytes(data)}
            one.inbox.extend([message] * self.copies(channel))
        return len(heard)

    def pipeline(self, transaction: bool = True) -> "Pipeline":
        return Pipeline(self)

    def pubsub(self, ignore_subscribe_messages: bool = False) -> "Listener":
        return Listener(self, ignore_subscribe_messages)


class Pipeline:
    """Calls that are carried out together."""

    def __init__(self, store: MemoryStore) -> None:
        self._store, self._calls = store, []

    def __getattr__(self, name: str):
        called = getattr(self._store, f"_{name}")
        return lambda *args, **kwargs: self._calls.append(partial(called, *args, **kwargs))

    def execute(self) -> list:
        self._store.ask()
        return self._execute()

    def _execute(self) -> list:
        calls, self._calls = self._calls, []
        return [call() for call in calls]


class Listener:
    """A connection for pub/sub."""

    def __init__(self, store: MemoryStore, silent: bool) -> None:
        self._store, self._silent = store, silent
        self.channels: dict[str, None] = {}
        self.inbox: deque[dict] = deque()
        self.broken = False
        store.world.running.process.at_kill.append(self.close)

    @property
    def subscribed(self) -> bool:
        return bool(self.channels)

    def subscribe(self, *channels: str) -> None:
        self._store.ask()
        self._subscribe(*channels)

    def _subscribe(self, *channels: str) -> None:
        if self not in self._store.listeners:
            self._store.listeners.append(self)
        for channel in channels:
            self.channels[channel] = None
            self._tell("subscribe", channel)

    def unsubscribe(self, *channels: str) -> None:
        self._store.ask()
        self._unsubscribe(*channels)

    def _unsubscribe(self, *channels: str) -> None:
        for channel in channels:
            self.channels.pop(channel, None)
            self._tell("unsubscribe", channel)

    def _tell(self, kind: str, channel: str) -> None:
        if not self._silent:
            told = {"type": kind, "pattern": None, "channel": channel.encode(), "data": len(self.channels)}
            self.inbox.append(told)

    def ping(self) -> None:
        self._check()
        if not self._store.silent:
            self.inbox.append({"type": "pong", "pattern": None, "channel": None, "data": b""})

    def _check(self) -> None:
        if self._lost:
            self.broken = True
            raise redis.ConnectionError("Connection closed by server.")

    def get_message(self, ignore_subscribe_messages: bool = False, timeout: float = 0.0) -> dict | None:
        world = self._store.world
        came = world.park(world.monotonic() + timeout, lambda: self._lost or (self.inbox and not self._store.silent))
        self._check()
        return self.inbox.popleft() if came else None

    @property
    def _lost(self) -> bool:
        return self.broken or not self._store.up

    def close(self) -> None:
        if self in self._store.listeners:
            self._store.listeners.remove(self)
