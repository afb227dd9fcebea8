"""Anything may come to the group's address: half packets, changed ones, foreign ones, and numbers out of all bounds."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from portal.broadcast import index, packets
from portal.broadcast.assembly import Assembly, Segment
from portal.broadcast.edge import Edge
from portal.broadcast.packets import DATAGRAM, HEAD, PAYLOAD, TAG, Packet, decode, encode, key_of
from tests.broadcasting import KEY, Air, movie

ONE = Packet(7, 1, 40, 1, 0, 5000, b"x" * 1000)
packets_made = st.builds(
    Packet, st.integers(0, 2**32 - 1), st.integers(0, 2**64 - 1), st.integers(1, 255), st.integers(0, 3600),
    st.integers(0, 2**23), st.integers(2**23 + PAYLOAD, 2**24 - 1), st.binary(min_size=1, max_size=PAYLOAD),
)  # fmt: skip


@given(packets_made)
def test_a_packet_is_read_as_it_was_written(packet):
    datagram = encode(KEY, packet)
    assert len(datagram) == HEAD.size + TAG + len(packet.data) <= DATAGRAM
    assert decode(KEY, datagram) == packet


@given(packets_made, st.integers(0, DATAGRAM * 8))
def test_a_bit_that_changed_is_found(packet, bit):
    datagram = bytearray(encode(KEY, packet))
    bit %= len(datagram) * 8
    datagram[bit // 8] ^= 1 << bit % 8
    assert decode(KEY, bytes(datagram)) is None


@given(packets_made, st.data())
def test_a_part_of_a_packet_is_none(packet, data):
    datagram = encode(KEY, packet)
    begin = data.draw(st.integers(0, len(datagram)))
    end = data.draw(st.integers(begin, len(datagram)))
    if (begin, end) != (0, len(datagram)):
        assert decode(KEY, datagram[begin:end]) is None
    assert decode(KEY, datagram + b"x") is None


@given(st.binary(max_size=2000))
def test_what_others_send_changes_nothing(datagram):
    edge = Edge(KEY, lambda: 0.5)
    edge.hear(datagram, 0)
    assert edge.current is None
    assert (edge.packets_received, edge.refused) == (0, 1)


def test_a_packet_with_another_key_is_refused():
    assert decode(key_of("another key of others"), encode(KEY, ONE)) is None


def test_a_short_key_is_refused():
    with pytest.raises(ValueError, match="16"):
        key_of("short")


@pytest.mark.parametrize(
    "wrong", [{"size": 999}, {"offset": 4001}, {"segment": 3601}, {"wait_ds": 0}, {"data": b""}], ids=str
)
def test_numbers_that_do_not_fit_are_refused_whoever_sends_them(wrong):
    assert decode(KEY, encode(KEY, replace(ONE, **wrong))) is None


def test_a_segment_of_two_sizes_keeps_the_first():
    one = Assembly(7, 40, 0)
    assert one.take(ONE)
    assert not one.take(replace(ONE, size=6000))
    assert len(one.segments[1].data) == 5000


def test_no_more_memory_is_taken_than_allowed():
    one = Assembly(7, 40, 0, most=3 * 2**20)
    taken = [one.take(replace(ONE, segment=n, size=2**20)) for n in range(1, 100)]
    assert sum(taken) == 3
    assert one.size == sum(len(segment.data) for segment in one.segments.values()) == 3 * 2**20
    assert not one.take(replace(ONE, segment=0, size=index.LARGEST + 1))


@pytest.mark.parametrize(
    "content", [b"\xff" * 100, b"", index.encode(movie().index)[:-1], b"\xdd\xff\xff\xff\xff"], ids=len
)
def test_an_index_that_is_none_ends_the_movie_and_not_the_edge(content):
    edge, content = Edge(KEY, lambda: 0.5), content or b"\x80"
    packet = Packet(7, 1, 40, 0, 0, len(content), content)
    edge.hear(encode(KEY, packet), 0)
    assert edge.current is None
    assert edge.refused == 1
    air = Air(movie())
    air.edges[edge] = 0.0, air
    air.random = lambda: 0.5
    air.go(9)
    assert edge.current.whole


@given(st.lists(st.tuples(st.integers(0, 30), st.integers(1, 12))))
def test_a_segment_is_missing_what_did_not_come(pieces):
    whole = bytes(range(31))
    segment, came = Segment(bytearray(31), [(0, 31)]), set()
    for begin, long in pieces:
        data = whole[begin : begin + long]
        segment.take_packet(begin, data)
        came |= set(range(begin, begin + len(data)))
        assert {n for a, b in segment.missing_ranges for n in range(a, b)} == set(range(31)) - came
        assert all(a < b for a, b in segment.missing_ranges)
        assert all(n not in came for a, b in segment.lost_ranges for n in range(a, b))
        assert all(segment.data[n] == n for n in came)


def test_what_is_there_is_not_written_over():
    segment = Segment(bytearray(10), [(0, 10)])
    segment.put(2, b"abc")
    segment.put(0, b"xxxxxx")
    assert bytes(segment.data[:6]) == b"xxabcx"


def test_a_gap_between_two_packets_is_known_at_the_second():
    segment = Segment(bytearray(10), [(0, 10)])
    segment.take_packet(2, b"ab")
    assert segment.lost_ranges == []
    segment.take_packet(6, b"ab")
    assert segment.lost_ranges == [(4, 6)]
    segment.take_packet(0, b"ab")  # it began again
    assert segment.lost_ranges == [(4, 6), (8, 10)]
    segment.put(4, b"ab")
    assert segment.lost_ranges == [(8, 10)]


def test_a_loss_is_known_long_before_it_is_needed():
    one, shown = Assembly(7, 40, 0), movie(20, 6000)
    index_packet = Packet(7, 1, 40, 0, 0, len(shown.contents[0]), shown.contents[0])
    assert one.take(index_packet)
    first, third = (replace(ONE, segment=19, offset=offset) for offset in (0, 2000))
    assert one.take(first)
    assert one.gaps(0, 0) == []
    assert one.take(third)
    assert [(gap.segment, gap.begin, gap.end, gap.due_ns) for gap in one.gaps(0, 0)] == [(19, 1000, 2000, 13 * 10**9)]


def test_the_tag_of_a_range_is_of_its_place():
    tags = {
        packets.range_tag(KEY, *place, b"x")
        for place in ((1, 2, 3, 4), (2, 2, 3, 4), (1, 3, 3, 4), (1, 2, 4, 4), (1, 2, 3, 5))
    }
    assert len(tags) == 5
