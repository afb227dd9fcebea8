"""One contract for Redis and for the store in memory: whatever `robots.bus` and its like ask, both answer the same."""

import pytest
import redis

from robots import bus
from tests.conftest import wait_for
from tests.world.store import MemoryStore
from tests.world.world import World

LISTEN_S = 5.0


class InMemory:
    def __init__(self):
        self.world = World(1)
        self.store = MemoryStore(self.world)

    def pass_time(self, seconds, over):
        self.world.sleep(seconds)
        assert over()

    def close(self):
        self.world.close()


class Real:
    def __init__(self):
        self.store = bus.connection()
        self.store.flushdb()

    def pass_time(self, seconds, over):
        wait_for(over, 60, "what ends by itself")

    def close(self):
        self.store.flushdb()


@pytest.fixture(params=["memory", "redis"])
def kind(request):
    if request.param == "redis":
        request.getfixturevalue("redis_server")
    made = InMemory() if request.param == "memory" else Real()
    yield made
    made.close()


@pytest.fixture
def store(kind):
    return kind.store


def heard(listener, number):
    """Return the next messages as (type, channel, data)."""
    found = []
    while len(found) < number:
        message = listener.get_message(timeout=LISTEN_S)
        assert message is not None, f"{found}: no more came"
        found.append((message["type"], message["channel"], message["data"]))
    return found


def test_values(store):
    assert store.ping() is True
    assert store.get("a") is None
    assert store.exists("a", "b") == 0
    assert store.set("a", 1)
    assert store.set("b", b"two", ex=100)
    assert (store.get("a"), store.get("b")) == (b"1", b"two")
    assert store.mget("a", "none", "b") == [b"1", None, b"two"]
    assert store.exists("a", "b", "none", "a") == 3
    assert store.set("a", 2, nx=True) is None
    assert store.set("c", 2.5, nx=True) is True
    assert (store.get("a"), store.get("c")) == (b"1", b"2.5")
    assert store.delete("a", b"c", "none") == 2
    assert store.exists("a") == 0


def test_lives_of_keys(kind, store):
    store.set("short", 1, ex=1)
    store.set("shorter", 1, px=900)
    store.set("kept", 1)
    assert store.expire("kept", 100) == 1
    assert store.expire("none", 100) == 0
    store.set("again", 1, ex=1)
    store.set("again", 2)  # lives on: a new value has a new life
    assert store.exists("short", "shorter") == 2
    kind.pass_time(1.1, lambda: not store.exists("short"))
    assert (store.get("short"), store.mget("short", "shorter")) == (None, [None, None])
    assert store.set("short", 3, nx=True) is True
    assert store.get("again") == b"2"


def test_names_by_pattern(store):
    for name in ("robot.mercury.1", "robot.mercury.12", "_kombu.binding.robot.mercury.1", "robot.pa10.1"):
        store.set(name, 1)
    assert sorted(store.scan_iter("robot.mercury.*", count=1000)) == [b"robot.mercury.1", b"robot.mercury.12"]
    assert list(store.scan_iter("nothing*")) == []


def test_lists_in_one_transaction(store):
    both = store.pipeline(transaction=True)
    both.rpushx("list", b"lost")
    both.rpush("list", b"a", b"b")
    both.rpushx("list", b"c")
    both.expire("list", 100)
    both.publish("nobody", b"x")
    assert both.execute() == [0, 2, 3, True, 0]
    assert store.lrange("list", 0, -1) == [b"a", b"b", b"c"]
    assert store.lrange("list", 1, 1) == [b"b"]
    assert store.lrange("none", 0, -1) == []
    again = store.pipeline(transaction=True)
    again.delete("list")
    again.rpush("list", b"new")
    assert again.execute() == [1, 1]
    assert store.lrange("list", 0, -1) == [b"new"]


def test_what_is_published(store):
    listener = store.pubsub(ignore_subscribe_messages=True)
    listener.subscribe("a", "b")
    assert heard_none(listener)
    assert store.publish("a", "text") == 1
    assert store.publish("b", b"\x00bytes") == 1
    assert store.publish("c", b"nobody") == 0
    assert heard(listener, 2) == [("message", b"a", b"text"), ("message", b"b", b"\x00bytes")]
    second = store.pubsub(ignore_subscribe_messages=True)
    second.subscribe("a")
    assert heard_none(second)
    assert store.publish("a", 5) == 2
    assert heard(listener, 1) == heard(second, 1) == [("message", b"a", b"5")]
    listener.unsubscribe("a")
    assert heard_none(listener)
    assert store.publish("a", b"x") == 1
    second.close()
    listener.close()


def heard_none(listener):
    """Tell whether nothing but the answers to subscriptions came."""
    return all(listener.get_message(timeout=0.05) is None for _ in range(3))


def test_the_answers_to_subscriptions_and_pings(store):
    listener = store.pubsub()
    assert not listener.subscribed
    listener.subscribe("a")
    listener.subscribe("b")
    assert heard(listener, 2) == [("subscribe", b"a", 1), ("subscribe", b"b", 2)]
    assert listener.subscribed
    listener.ping()
    assert heard(listener, 1) == [("pong", None, b"")]
    listener.unsubscribe("a")
    assert heard(listener, 1) == [("unsubscribe", b"a", 1)]
    listener.close()


def test_a_store_that_is_away(kind, store, request):
    listener = store.pubsub(ignore_subscribe_messages=True)
    listener.subscribe("a")
    assert heard_none(listener)
    if isinstance(kind, InMemory):
        store.up = False
    else:
        server = request.getfixturevalue("redis_server")
        server.stop()
    try:
        for ask in (store.ping, lambda: store.get("a"), lambda: store.publish("a", 1), lambda: store.expire("a", 1)):
            with pytest.raises((redis.RedisError, OSError)):
                ask()
        with pytest.raises((redis.RedisError, OSError)):
            for _ in range(100):
                listener.get_message(timeout=0.1)
    finally:
        if isinstance(kind, InMemory):
            store.up = True
        else:
            server.start()
    assert store.ping() is True
