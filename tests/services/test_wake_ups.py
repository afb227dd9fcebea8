"""How the owner is woken: by pub/sub if it listens, by its Celery queue if nobody does."""

import pytest

from robots import bus

pytestmark = [pytest.mark.usefixtures("redis_server"), pytest.mark.timed]


@pytest.fixture(autouse=True)
def _empty():
    bus.connection().flushall()
    yield
    bus.connection().flushall()


def queued():
    return bus.connection().llen(bus.queue_name("mercury", 7))


def test_pub_sub_is_enough_where_somebody_listens():
    with bus.listener().pubsub(ignore_subscribe_messages=True) as listener:
        listener.subscribe(bus.wake_channel("mercury"))
        listener.get_message(timeout=10)
        assert bus.wake_owner("mercury", 7)
        assert listener.get_message(timeout=10)["data"] == b"wake"
    assert queued() == 0


def test_the_queue_keeps_the_wake_up_where_nobody_listens():
    assert bus.wake_owner("mercury", 7)
    assert queued() == 1


def test_a_lost_wake_up_is_counted_and_never_raised(redis_server):
    redis_server.stop()
    try:
        before = bus.failures["wake"]
        assert not bus.wake_owner("mercury", 7)
        assert bus.failures["wake"] == before + 1
    finally:
        redis_server.start()
