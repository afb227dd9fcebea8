"""Deltas with short heads over one socket: whole again at its other end, whatever comes and from whomever."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.kit.contract.packet_chain import PacketChain
from robots.kit.contract.short_heads import FIRST, LATER_MS, SHORT, ShortHeads
from robots.kit.contract.streams import HEAD, MOST, StreamPacket, pack, unpack
from tests.environment import ROOT

VECTORS = json.loads((ROOT / "tests/vectors/short_heads.json").read_text())
# what a socket is given: mostly what follows, and anything else between
PACKETS = st.lists(
    st.tuples(
        st.integers(0, MOST - 1), st.sampled_from([1, 1, 1, 1, 0, 2, 32, 33]), st.integers(-2, LATER_MS + 2),
        st.booleans(), st.sampled_from([0, 0, 0, 1]), st.binary(max_size=6),
    ),
    max_size=60,
)  # fmt: skip


@pytest.mark.parametrize("one", VECTORS, ids=lambda one: one["what"])
def test_heads_are_short_and_whole_again_as_the_browser_reads_them(one):
    writer, reader = ShortHeads(), ShortHeads()
    for told in one["packets"]:
        packet = StreamPacket(
            told["stream"], told["number"], told["at_ms"], told["key"], bytes.fromhex(told["data"]), told["run"]
        )  # fmt: skip
        sent = writer.shorten(pack(packet))
        assert sent.hex() == told["sent"]
        assert reader.restore(sent) == pack(packet)


@given(PACKETS, st.integers(0, 2**32 - 1))
def test_every_packet_arrives_as_it_was_whatever_follows_what(steps, first):
    writer, reader = ShortHeads(), ShortHeads()
    numbers, runs, at_ms = [first] * MOST, [0] * MOST, 1_700_000_000_000
    for stream, more, later_ms, key, other, data in steps:
        numbers[stream] = (numbers[stream] + more) % 2**32
        runs[stream] ^= other
        at_ms += later_ms
        whole = pack(StreamPacket(stream, numbers[stream], at_ms, key, data, runs[stream]))
        sent = writer.shorten(whole)
        assert len(sent) in (len(whole), len(whole) - HEAD.size + SHORT.size)
        assert reader.restore(sent) == whole


@given(st.integers(1, 500))
def test_of_a_key_packet_and_the_deltas_after_it_the_key_packet_alone_has_a_whole_head(many):
    writer, chain = ShortHeads(), PacketChain(unpack)
    for n in range(many):
        whole = pack(StreamPacket(3, 7 + n, 1000 + 20 * n, n == 0, b"x" * 12, 9))
        assert chain.add(whole)
        assert len(writer.shorten(whole)) == (28 if n == 0 else 15)


@given(st.binary(max_size=30), st.booleans())
def test_any_bytes_are_a_packet_or_nothing_or_refused(data, short):
    reader = ShortHeads()
    reader.restore(pack(StreamPacket(0, 1, 1000, True, b"key")))
    try:
        found = reader.restore(bytes((FIRST,)) + data if short else data)
    except ValueError:
        return
    assert found is None or pack(unpack(found)) == found


def test_after_a_delta_that_was_lost_none_is_read_before_a_whole_head():
    writer, reader = ShortHeads(), ShortHeads()
    packets = [pack(StreamPacket(0, n, 1000 + n, n in (1, 5), bytes((n,)))) for n in range(1, 8)]
    read = [
        reader.restore(writer.shorten(packet)) if n != 1 else writer.shorten(packet) for n, packet in enumerate(packets)
    ]
    assert read[2:4] == [None, None]
    assert read[4:] == packets[4:]
