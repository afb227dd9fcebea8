"""A viewer of a byte stream is given a key packet and then each delta after it, whatever is lost or comes twice."""

from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from portal.live.streams import Streams
from robots.kit.contract.packet_chain import PacketChain
from robots.kit.contract.session import Session
from robots.kit.contract.streams import StreamPacket, pack, unpack

STEPS = st.lists(st.sampled_from(["key", "delta", "delta", "delta"]), max_size=30)


def told(steps, stream=0):
    """Return what an owner publishes, and what Redis keeps after each of it."""
    kept, packets, after = [], [], []
    for number, step in enumerate(["key", *steps], 1):
        packets.append(pack(StreamPacket(stream, number, 1000 + number, step == "key", b"%d" % number)))
        kept = [packets[-1]] if step == "key" else [*kept, packets[-1]]
        after.append(kept)
    return packets, after


def whole(packets):
    """Tell whether these are a key packet with the deltas that follow it, one after another."""
    found = [unpack(p) for p in packets]
    starts = [i for i, p in enumerate(found) if p.key]
    follow = all(b.key or b.number == a.number + 1 for a, b in pairwise(found))
    return not found or (starts[:1] == [0] and follow)


@given(STEPS, st.data())
def test_whoever_comes_at_any_time_and_misses_anything_is_given_a_whole_chain(steps, data):
    packets, after = told(steps)
    hub, viewer, given_to = Streams(), {}, []
    for at, packet in enumerate(packets):
        fate = data.draw(st.sampled_from(["heard", "heard", "lost", "twice"]))
        missed = not all(hub.take("rover", packet) for _ in range({"lost": 0, "twice": 2}.get(fate, 1)))
        if missed and data.draw(st.booleans()):  # the answer of Redis may be a little older than what is heard
            hub.restore("rover", [after[data.draw(st.integers(max(0, at - 2), at))]])
        if data.draw(st.booleans()):
            given_to += hub.news("rover", viewer)
            assert whole(given_to)
    hub.restore("rover", [after[-1]])
    newcomer = hub.news("rover", {})
    assert newcomer == after[-1], "a newcomer is given the newest key packet and all deltas after it"
    given_to += hub.news("rover", viewer)
    assert whole(given_to)
    assert given_to[-1] == packets[-1]


def test_what_is_heard_while_redis_is_read_is_not_lost():
    packets, after = told(["delta", "delta", "delta"])
    hub = Streams()
    assert not hub.take("rover", packets[2]), "what it follows was missed"
    assert not hub.take("rover", packets[3])
    hub.restore("rover", [after[1]])  # as it was before both
    assert hub.news("rover", {}) == packets


def test_a_chain_of_an_owner_before_is_not_taken_for_the_newer_one():
    old, kept = told(["delta"])
    new = pack(StreamPacket(0, 1, 999_999, True, b"new", run=1))
    hub = Streams()
    hub.restore("rover", [])
    assert hub.take("rover", new)
    hub.restore("rover", [kept[-1]])
    assert hub.news("rover", {}) == [new]
    assert not hub.take("rover", old[1])
    assert hub.news("rover", {}) == [new]


def test_streams_and_robots_are_kept_apart_and_forgotten():
    hub = Streams()
    first, second = told(["delta"])[1][-1], told([], stream=1)[1][-1]
    hub.restore("rover", [first, second])
    hub.restore("rat", [])
    assert hub.news("rover", {}) == first + second
    assert (hub.news("rat", {}), hub.knows("rat"), hub.knows("cat")) == ([], True, False)
    hub.forget("rover")
    assert hub.news("rover", {}) == []


@given(st.binary(max_size=40))
def test_any_bytes_are_a_packet_or_refused(data):
    try:
        packet = unpack(data)
    except ValueError:
        return
    assert unpack(pack(packet)) == packet
    PacketChain(unpack).add(data)


@pytest.mark.parametrize("data", [b"", b"\x01" * 16, b"\x03" * 15])
def test_what_is_too_short_or_another_type_is_refused(data):
    with pytest.raises(ValueError, match="not a packet of a byte stream"):
        unpack(data)


class Rover(Session):
    connect = state = hold = lambda self: None

    def execute(self, kind, args, permit, on_stage):
        return None

    def close(self):
        return None


def test_a_driver_that_nobody_listens_to_is_asked_for_key_packets_and_fails_at_nothing():
    rover, heard = Rover("", {}), []
    assert rover.stream("map", b"all")
    assert rover.stream("map", b"change", key=False)
    rover.on_packet = lambda *packet: bool(heard.append(packet))
    assert not rover.stream("map", b"all")
    assert heard == [("map", b"all", True)]
