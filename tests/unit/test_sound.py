"""Packets of sound, how fast they may follow each other, and who is given them."""

import asyncio
import json
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from portal.live import rooms
from portal.live.rooms import Room
from portal.live.viewer import SOUNDS, Viewer, Wish
from robots.kit.contract.sound import HEAD, LARGEST, LONGEST_MS, TYPE, SoundPacket, pack, sentence, unpack
from workers.media.sound import DEPTH, MOST, Pacer

VECTORS = json.loads((Path(__file__).resolve().parents[1] / "vectors" / "sound_packets.json").read_text())
EVERY_S = 0.06


@pytest.mark.parametrize("one", VECTORS["read"], ids=lambda one: one["what"])
def test_sound_is_packed_as_the_browser_reads_it(one):
    data = one["said"].encode() if one["said"] else bytes.fromhex(one["data"])
    packet = SoundPacket(one["number"], one["at_ms"], one["ms"], data, one["run"])
    assert pack(packet).hex() == one["hex"]
    assert unpack(pack(packet)) == packet
    assert packet.text == one["said"]


@pytest.mark.parametrize("one", VECTORS["refused"], ids=lambda one: one["what"])
def test_what_the_browser_refuses_is_refused_here_too(one):
    with pytest.raises(ValueError):
        unpack(bytes.fromhex(one["hex"]))


@given(
    st.integers(0, 2**32 - 1), st.integers(-(2**63), 2**63 - 1), st.integers(1, LONGEST_MS),
    st.binary(min_size=1, max_size=LARGEST), st.integers(0, 255),
)  # fmt: skip
def test_every_packet_comes_back(number, at_ms, ms, data, run):
    packet = SoundPacket(number, at_ms, ms, data, run)
    assert unpack(pack(packet)) == packet


@given(st.one_of(st.binary(max_size=60), st.binary(max_size=60).map(lambda rest: bytes([TYPE]) + rest)))
def test_rubbish_is_refused_or_read_as_what_packs_to_the_same(data):
    try:
        packet = unpack(data)
    except ValueError:
        return
    assert len(data) > HEAD.size
    assert pack(packet)[4:] == data[4:]
    assert isinstance(packet.text, str)


@pytest.mark.parametrize("packet", [
    SoundPacket(1, 0, 60, b""), SoundPacket(1, 0, 60, bytes(LARGEST + 1)), SoundPacket(1, 0, LONGEST_MS + 1, b"a"),
])  # fmt: skip
def test_what_cannot_be_read_is_not_packed(packet):
    with pytest.raises(ValueError):
        pack(packet)


@given(st.text(min_size=1, max_size=3000))
def test_a_sentence_that_is_too_long_is_cut_between_two_letters(text):
    said = unpack(pack(sentence(text, 5))).text
    assert text.startswith(said)
    assert len(text.encode()) - len(said.encode()) <= max(0, len(text.encode()) - LARGEST + 3)


def sent(pacer, arrivals):
    """Return when the pieces that arrive at these times are sent (s); a wait delays all that follow."""
    now, found = 0.0, []
    for at in arrivals:
        now = max(now, at)
        if (wait_s := pacer.wait_s(now)) is not None:
            now += wait_s
            found.append(now)
    return found


def test_pieces_that_come_as_they_are_heard_all_pass_at_once():
    arrivals = [n * EVERY_S + (0.05 if n % 7 == 0 else 0.0) for n in range(2000)]
    assert sent(Pacer(EVERY_S, 0.0), arrivals) == arrivals


def test_after_a_pause_what_was_missed_is_left_out():
    before, after = [n * EVERY_S for n in range(50)], [5.0 + n * EVERY_S for n in range(50)]
    passed = sent(Pacer(EVERY_S, 0.0), [*before, *[5.0] * 40, *after])
    assert len(before) + len(after) <= len(passed) <= len(before) + len(after) + DEPTH
    assert passed[-40:] == after[-40:], "what is heard is of now"


def test_a_file_that_comes_at_once_is_slowed_down():
    passed = sent(Pacer(EVERY_S, 0.0), [0.0] * 1000)
    assert len(passed) > 800
    assert passed[-1] > (len(passed) - MOST) * EVERY_S
    assert sum(at < 1.0 for at in passed) <= DEPTH + 1 / EVERY_S + 1


def listener(room, **wish):
    one = Viewer("arm", wish=Wish(**wish))
    room.add(one)
    return one


@pytest.fixture
def computed(monkeypatch):
    made = []
    monkeypatch.setattr(rooms, "binary_frame", lambda data: made.append(data) or data)
    return made


def test_only_those_who_listen_are_given_sound_and_a_slow_one_keeps_a_third_of_a_second(computed):
    async def listen():
        room = Room("arm")
        plain = listener(room)
        room.give_sound(b"nobody listens")
        assert not computed
        one = listener(room, sound=True)
        assert "sound" in room.watched()
        assert "farhand:arm:sound" in room.channels()
        packets = [b"%d" % n for n in range(20)]
        for data in packets:
            room.give_sound(data)
        assert plain.take_sounds() == []
        assert one.take_sounds() == packets[-SOUNDS:]
        assert one.take_sounds() == []
        room.give_sound(b"last")
        room.remove(one)
        one.choose(Wish())
        assert one.take_sounds() == [], "it wants no sound any more"
        assert "sound" not in room.watched()
        assert not room.listeners

    asyncio.run(listen())
