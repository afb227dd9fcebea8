"""A Redis that takes connections and says nothing: its client gives up after a limit and tries again."""

import asyncio
import contextlib
import socket
import threading

import pytest
import redis

from portal.live import store
from portal.live.subscriptions import Subscriber, Subscriptions
from robots import bus
from tests.conftest import wait_for


@pytest.fixture
def silent(settings):
    """The connections that a silent Redis has taken."""
    server, taken = socket.create_server(("127.0.0.1", 0)), []

    def take():
        with contextlib.suppress(OSError):
            while True:
                taken.append(server.accept()[0])

    threading.Thread(target=take, daemon=True).start()
    settings.REDIS_URL = f"redis://:S3cret@127.0.0.1:{server.getsockname()[1]}/0"
    yield taken
    server.close()
    for one in taken:
        one.close()


def test_a_connection_for_pub_sub_is_given_up(silent, monkeypatch):
    monkeypatch.setattr(bus.store, "OPEN_S", 0.2)
    with pytest.raises(redis.RedisError):
        bus.listener().pubsub().subscribe("x")
    assert silent


def test_the_subscription_to_people_is_tried_again(silent, monkeypatch):
    monkeypatch.setattr(store, "SILENT_S", 0.1)
    monkeypatch.setattr(store, "AGAIN_S", 0.01)

    async def attached():
        made, one = Subscriptions(), Subscriber(1)
        made.attach(one)
        await asyncio.to_thread(wait_for, lambda: len(silent) >= 3, 60, "three attempts")
        assert not made.link
        made.detach(one)

    asyncio.run(attached())
