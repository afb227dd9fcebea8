"""The asynchronous face of a store in memory: what the sockets of a web process ask of Redis, within its event loop."""

import asyncio
from collections.abc import Callable

import redis

from tests.world.loop import WorldLoop
from tests.world.store import LATENCY_S, Listener, MemoryStore, Pipeline


def loop() -> WorldLoop:
    return asyncio.get_running_loop()  # type: ignore[return-value]


class AsyncStore:
    """A connection of an event loop to a store, as `redis.asyncio.Redis` without a time limit: a silent store is awaited."""

    def __init__(self, store: MemoryStore) -> None:
        self._store = store
        self._listeners: list[AsyncListener] = []

    async def ask(self) -> None:
        """Carry a call there and back. Raises redis.ConnectionError."""
        await asyncio.sleep(LATENCY_S)
        await loop().until(lambda: not self._store.silent)
        if not self._store.up:
            raise redis.ConnectionError("the store is away")

    def __getattr__(self, name: str) -> Callable:
        """Return a command of Redis."""
        command = getattr(self._store, f"_{name}")

        async def call(*args, **kwargs):
            await self.ask()
            return command(*args, **kwargs)

        return call

    def pipeline(self, transaction: bool = True) -> "AsyncPipeline":
        return AsyncPipeline(self._store, self)

    def pubsub(self, ignore_subscribe_messages: bool = False) -> "AsyncListener":
        made = AsyncListener(self._store, self, ignore_subscribe_messages)
        self._listeners.append(made)
        return made

    async def aclose(self) -> None:
        for listener in self._listeners:
            listener.close()


class AsyncPipeline(Pipeline):
    """Calls that are carried out together."""

    def __init__(self, store: MemoryStore, connection: AsyncStore) -> None:
        super().__init__(store)
        self._connection = connection

    async def execute(self) -> list:
        await self._connection.ask()
        return self._execute()


class AsyncListener(Listener):
    """A connection for pub/sub. The first call opens it; what is asked later is answered by messages."""

    def __init__(self, store: MemoryStore, connection: AsyncStore, ignores: bool) -> None:
        super().__init__(store, silent=False)
        self._connection, self._ignores, self._opened = connection, ignores, False

    async def _open(self) -> None:
        if not self._opened:
            await self._connection.ask()
            self._opened = True
        self._check()

    async def subscribe(self, *channels: str) -> None:
        await self._open()
        self._subscribe(*channels)

    async def unsubscribe(self, *channels: str) -> None:
        await self._open()
        self._unsubscribe(*channels)

    async def ping(self) -> None:
        await self._open()
        self.inbox.append({"type": "pong", "pattern": None, "channel": None, "data": b""})

    async def get_message(self, timeout: float = 0.0) -> dict | None:
        """Return the next message; None after so many seconds, and for an answer that is ignored."""
        try:
            async with asyncio.timeout(timeout):
                await loop().until(lambda: self._lost or (self.inbox and not self._store.silent))
        except TimeoutError:
            return None
        self._check()
        message = self.inbox.popleft()
        return None if self._ignores and message["type"] in ("subscribe", "unsubscribe") else message
