"""Which bell rings: the quick one where the owner hears it, the queue's where nobody does."""

import pytest

from robots import bus

pytestmark = [pytest.mark.service, pytest.mark.usefixtures("redis_server")]


@pytest.fixture(autouse=True)
def _empty():
    bus.connection().flushall()
    yield
    bus.connection().flushall()


def queued():
    return bus.connection().llen(bus.queue_name("mercury", 7))


def test_the_quick_bell_is_enough_where_somebody_listens():
    with bus.listener().pubsub(ignore_subscribe_messages=True) as ear:
        ear.subscribe(bus.bell_channel("mercury"))
        ear.get_message(timeout=1)
        assert bus.ring("mercury", 7)
        assert ear.get_message(timeout=1)["data"] == b"look"
    assert queued() == 0


def test_the_queue_keeps_the_bell_where_nobody_listens():
    assert bus.ring("mercury", 7)
    assert queued() == 1


def test_a_lost_ring_is_counted_and_never_raised(redis_server):
    redis_server.stop()
    try:
        before = bus.failures["ring"]
        assert not bus.ring("mercury", 7)
        assert bus.failures["ring"] == before + 1
    finally:
        redis_server.start()
