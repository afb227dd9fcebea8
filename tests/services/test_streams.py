"""The owner's byte streams and Redis: packets kept for new viewers, also while Redis is away, and limits for drivers."""

import pytest

from robots import bus
from robots.kit.contract.streams import LONGEST, MOST_DELTAS, Stream, unpack
from tests.conftest import FakeClock
from workers.media.streams import REFRESH_S, Streams

pytestmark = pytest.mark.timed


@pytest.fixture
def streams(redis_server):
    bus.connection().flushall()
    made = Streams("rover", (Stream("map"), Stream("objects")), FakeClock())
    yield made
    if not bus.alive():
        redis_server.start()
    bus.connection().flushall()


def kept(stream=0):
    found = bus.connection().lrange(bus.stream_key("rover", stream), 0, -1)
    return [(p.number, p.key, p.data) for p in map(unpack, found)]


def test_the_newest_key_packet_and_its_deltas_are_kept_for_newcomers(streams):
    listener = bus.listener().pubsub(ignore_subscribe_messages=True)
    listener.subscribe(bus.stream_channel("rover"))
    listener.get_message(timeout=10)
    assert not streams.take("map", b"abc", True)
    streams.publish()
    assert not streams.take("map", b"d", False)
    assert not streams.take("map", b"e", False)
    assert not streams.take("objects", b"xyz", True)
    streams.publish()
    assert (kept(0), kept(1)) == ([(1, True, b"abc"), (2, False, b"d"), (3, False, b"e")], [(1, True, b"xyz")])
    heard = [unpack(listener.get_message(timeout=10)["data"]) for _ in range(4)]
    assert [(p.stream, p.number) for p in heard] == [(0, 1), (0, 2), (0, 3), (1, 1)]
    streams.take("map", b"new", True)
    streams.publish()
    assert kept(0) == [(4, True, b"new")]


def test_what_is_told_before_it_is_published_begins_with_the_newest_key_packet(streams):
    streams.take("map", b"old", True)
    streams.take("map", b"d", False)
    streams.take("map", b"new", True)
    streams.publish()
    assert kept() == [(3, True, b"new")]


def test_a_delta_that_nothing_stands_before_is_left_out_and_a_key_packet_asked_for(streams):
    assert streams.take("map", b"d", False)
    streams.take("map", b"abc", True)
    streams.restart(2)  # a new driver
    assert streams.take("map", b"d", False)
    streams.publish()
    assert kept() == []


@pytest.mark.parametrize("size", [1, LONGEST // 2])
def test_deltas_are_bounded_in_number_and_size(streams, size):
    streams.take("map", b"abc", True)
    taken = 0
    while not streams.take("map", bytes(size), False):
        taken += 1
        assert taken <= MOST_DELTAS
    for _ in range(10):
        assert streams.take("map", bytes(size), False), "what comes after is left out"
    streams.publish()
    assert len(kept()) == taken + 2
    assert sum(len(data) for _, _, data in kept()) <= 2 * LONGEST + 3


def test_what_is_too_long_or_not_declared_is_refused(streams):
    with pytest.raises(ValueError, match="1048577 bytes"):
        streams.take("map", bytes(LONGEST + 1), True)
    with pytest.raises(ValueError, match="no stream 'sounds'"):
        streams.take("sounds", b"", True)


def test_without_redis_nothing_waits_and_nothing_is_lost(streams, redis_server):
    streams.take("map", b"abc", True)
    streams.publish()
    redis_server.stop()
    streams.take("map", b"d", False)
    streams.publish()
    streams.take("map", b"e", False)
    redis_server.start()  # empty
    streams._clock.go(REFRESH_S)
    streams.publish()
    assert kept() == [(1, True, b"abc"), (2, False, b"d"), (3, False, b"e")]
