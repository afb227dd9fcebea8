"""One contract for Redis and for the store in memory, as sockets speak with them: asynchronously, over one connection."""

import asyncio

import pytest
import redis

from portal.live import store
from robots import bus
from tests.conftest import wait_for
from tests.world.async_store import AsyncStore
from tests.world.loop import WorldLoop
from tests.world.store import MemoryStore
from tests.world.world import World

LISTEN_S = 5.0


class InMemory:
    def __init__(self):
        self.world = World(1)
        self.store = MemoryStore(self.world)

    def run(self, body):
        """Run a coroutine function with a connection; `aside` calls what another process does."""

        def here():
            loop = WorldLoop(self.world)
            try:
                loop.run_until_complete(body(AsyncStore(self.store), self.aside))
            finally:
                loop.close()

        self.world.spawn(here, "loop").join()
        self.world.check_errors()

    async def aside(self, call):
        done = []
        self.world.spawn(lambda: done.append(call(self.store)), "aside")
        await asyncio.get_running_loop().until(lambda: done)
        return done[0]

    def up(self, up):
        self.store.up = up

    def close(self):
        self.world.close()


class Real:
    def __init__(self, server):
        self.server = server
        bus.connection().flushdb()

    def run(self, body):
        async def here():
            connection = store.listener()
            try:
                await body(connection, self.aside)
            finally:
                await connection.aclose()

        asyncio.run(here())

    async def aside(self, call):
        return await asyncio.to_thread(call, bus.connection())

    def up(self, up):
        self.server.start() if up else self.server.stop()

    def close(self):
        wait_for(bus.alive, 60, "Redis")
        bus.connection().flushdb()


@pytest.fixture(params=["memory", "redis"])
def kind(request):
    made = InMemory() if request.param == "memory" else Real(request.getfixturevalue("redis_server"))
    yield made
    made.close()


async def heard(listener, number):
    """Return the next messages as (type, channel, data)."""
    found = []
    while len(found) < number:
        message = await listener.get_message(timeout=LISTEN_S)
        assert message is not None, f"{found}: no more came"
        found.append((message["type"], message["channel"], message["data"]))
    return found


def test_values(kind):
    async def body(store, aside):
        assert await store.set("a", 1, ex=4)
        assert await aside(lambda other: other.get("a")) == b"1"
        seconds, microseconds = await store.time()
        assert seconds > 10**9
        assert 0 <= microseconds < 10**6
        both = store.pipeline(transaction=False)
        both.hset("watchers", "one", "2 3")
        both.hset("watchers", "two", 4)
        both.hset("watchers", "two", 5)
        both.expire("watchers", 80)
        both.hgetall("watchers")
        assert await both.execute() == [1, 1, 0, True, {b"one": b"2 3", b"two": b"5"}]
        assert await store.hdel("watchers", b"one", b"none") == 1
        assert await aside(lambda other: other.hgetall("watchers")) == {b"two": b"5"}
        assert await store.hdel("watchers", "two") == 1
        assert await aside(lambda other: other.exists("watchers")) == 0
        lists = store.pipeline(transaction=False)
        lists.lrange("none", 0, -1)
        assert await lists.execute() == [[]]

    kind.run(body)


def test_what_is_published(kind):
    async def body(store, aside):
        listener = store.pubsub()
        await listener.subscribe("a")
        await listener.subscribe("b", "c")
        assert await heard(listener, 3) == [("subscribe", b"a", 1), ("subscribe", b"b", 2), ("subscribe", b"c", 3)]
        assert await aside(lambda other: other.publish("b", b"\x00text")) == 1
        await listener.ping()
        assert await heard(listener, 2) == [("message", b"b", b"\x00text"), ("pong", None, b"")]
        await listener.unsubscribe("b", "c")
        assert await heard(listener, 2) == [("unsubscribe", b"b", 2), ("unsubscribe", b"c", 1)]
        assert await aside(lambda other: other.publish("b", 1)) == 0
        assert await listener.get_message(timeout=0.05) is None

    kind.run(body)


def test_answers_that_are_ignored(kind):
    async def body(store, aside):
        listener = store.pubsub(ignore_subscribe_messages=True)
        await listener.subscribe("a")
        assert await listener.get_message(timeout=LISTEN_S) is None  # at once
        assert await aside(lambda other: other.publish("a", 5)) == 1
        assert await heard(listener, 1) == [("message", b"a", b"5")]
        await store.aclose()
        async with asyncio.timeout(60):
            while await aside(lambda other: other.publish("a", 5)):
                await asyncio.sleep(0.01)

    kind.run(body)


def test_a_store_that_is_away(kind):
    async def body(store, aside):
        listener = store.pubsub()
        await listener.subscribe("a")
        await heard(listener, 1)
        await store.set("a", 1)
        await aside(lambda _: kind.up(False))
        try:
            for ask in (lambda: store.set("a", 1), store.time, lambda: store.pubsub().subscribe("a")):
                with pytest.raises((redis.RedisError, OSError)):
                    await ask()
            with pytest.raises((redis.RedisError, OSError)):
                while True:
                    await listener.get_message(timeout=LISTEN_S)
        finally:
            await aside(lambda _: kind.up(True))

    kind.run(body)
