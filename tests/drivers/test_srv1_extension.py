"""Our frames behind `%`: each is read as it was written, bounded, and found among whatever else arrives."""

from binascii import crc_hqx
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.kit.drivers.srv1 import answers, extension, framing
from robots.kit.drivers.srv1.answers import Acknowledgement, Entries, Entry, Event, Reason, Refusal, Status
from robots.kit.drivers.srv1.extension import (  # fmt: skip
    HOLD,
    Activate,
    Ask,
    Claim,
    Hold,
    Journal,
    Patrol,
    Permit,
    Velocity,
)
from robots.kit.drivers.srv1.framing import ANSWER, COMMAND, LONGEST_ANSWER, LONGEST_COMMAND, Frame, Frames
from robots.kit.drivers.srv1.protocol import Malformed


def within(limits):
    return st.integers(limits.low, limits.high)


def scaled(limits, per=1000):
    """Generate numbers as a decoder gives them: an integer divided, so that what was written is read exactly."""
    return within(limits).map(lambda n: n / per)


@st.composite
def areas(draw):
    (x0, x1), (y0, y1) = (sorted(draw(st.lists(scaled(framing.MM), min_size=2, max_size=2))) for _ in "xy")
    return x0, y0, x1, y1


COMMANDS = st.one_of(
    st.builds(Claim, within(framing.EPOCH)), st.just(Hold()), st.just(Ask()),
    st.builds(Patrol, within(framing.EPOCH), within(framing.UPTIME_MS)),
    st.builds(
        Velocity, within(framing.EPOCH), scaled(framing.MM_S), scaled(framing.MRAD_S), within(framing.UPTIME_MS)
    ),
    st.builds(
        Permit, within(framing.EPOCH), within(framing.UPTIME_MS), st.integers(0, 2000).map(lambda n: n / 1000), areas()
    ),
    st.builds(Activate, within(framing.EPOCH), within(framing.CRC)), st.builds(Journal, within(framing.NUMBER)),
)  # fmt: skip
ENTRIES = st.builds(
    Entry,
    within(framing.NUMBER),
    within(framing.UPTIME_MS),
    st.sampled_from(Event),
    within(framing.NUMBER),
    scaled(framing.MM),
    scaled(framing.MM),
)
STATUSES = st.builds(
    Status, within(framing.BOOT), within(framing.EPOCH), within(framing.NUMBER), st.booleans(), st.booleans(),
    st.sampled_from(answers.ENDS), st.sampled_from(answers.MODES), scaled(framing.MM), scaled(framing.MM),
    scaled(framing.MRAD), scaled(framing.MM_S), scaled(framing.MRAD_S), scaled(framing.RANGE_MM),
    scaled(framing.RANGE_MM), scaled(framing.MV), scaled(framing.DECIDEGREES, 10), scaled(framing.THOUSANDTHS),
    scaled(framing.THOUSANDTHS), st.booleans(), within(framing.SIDES), within(framing.CRC), within(framing.PERMIT_MS),
    within(framing.NUMBER), within(framing.UPTIME_MS), st.sampled_from(answers.STATUSES),
    st.none() | st.tuples(scaled(framing.RANGE_MM), scaled(framing.MRAD)),
)  # fmt: skip
ANSWERS = st.one_of(
    STATUSES,
    st.builds(Acknowledgement, st.sampled_from("pu"), within(framing.NUMBER), within(framing.UPTIME_MS)),
    st.builds(Refusal, st.sampled_from(sorted(extension.COMMANDS)), st.sampled_from(Reason)),
    st.lists(ENTRIES, max_size=4).map(lambda entries: Entries(tuple(entries))),
)


def close(one, other):
    """Tell whether two messages are equal but for the rounding of their numbers."""
    if type(one) is not type(other):
        return False
    for name, value in vars(one).items():
        there = getattr(other, name)
        if isinstance(value, float) or (isinstance(value, tuple) and value and isinstance(value[0], float)):
            if there != pytest.approx(value, abs=1e-6):
                return False
        elif there != value:
            return False
    return True


@given(COMMANDS)
def test_a_command_is_read_as_it_was_written(command):
    data = extension.encode(command)
    assert len(data) <= LONGEST_COMMAND
    (frame,) = Frames(COMMAND).feed(data)
    assert close(extension.decode(frame), command)


@given(ANSWERS)
def test_an_answer_is_read_as_it_was_written(answer):
    data = answers.encode(answer)
    assert len(data) <= LONGEST_ANSWER
    (frame,) = Frames(ANSWER).feed(data)
    assert close(answers.decode(frame), answer)


@given(STATUSES, st.sampled_from(["5000", "-1,0", "100001,0", "5000,6285", "5000,0,0", "5000,", "nan,0"]))
def test_a_beacon_that_no_tower_tells_is_refused(status, told):
    frame = replace(status, beacon=None).encode()
    with pytest.raises(Malformed):
        answers.decode(Frame(frame.letter, f"{frame.payload},{told}"))


def test_a_frame_is_what_the_description_says():
    assert extension.encode(Claim(7)) == b"%%c7*%04X\n" % crc_hqx(b"c7", 0)
    assert b"%%h*%04X\n" % crc_hqx(b"h", 0) == HOLD
    assert answers.encode(Refusal("v", Reason.LATE)) == b"##%%v!late*%04X\r\n" % crc_hqx(b"v!late", 0)


noise = st.binary(max_size=40).filter(lambda data: b"%" not in data)


@given(st.lists(st.tuples(noise, ANSWERS), max_size=4), st.integers(1, 17), noise)
def test_frames_are_found_among_noise_in_pieces(parts, size, last):
    data = b"".join(before + answers.encode(answer) for before, answer in parts) + last
    frames, found = Frames(ANSWER), []
    for at in range(0, len(data), size):
        found += frames.feed(data[at : at + size])
    assert [frame.encode(ANSWER) for frame in found] == [answers.encode(answer) for _, answer in parts]


@given(COMMANDS, st.data())
def test_a_bit_that_is_spoilt_is_noticed(command, data):
    encoded = bytearray(extension.encode(command))
    bit = data.draw(st.integers(0, 8 * len(encoded) - 1))
    encoded[bit // 8] ^= 1 << bit % 8
    assert not Frames(COMMAND).feed(bytes(encoded))


@given(st.binary(max_size=400), st.sampled_from((COMMAND, ANSWER)))
def test_garbage_ends_no_reader_and_the_next_frame_is_found(data, start):
    frames = Frames(start)
    frames.feed(data)
    frames.feed(start + b"x" * 300 + b"\r\n")
    right = Frame("a", "1,2").encode(start)
    assert [frame.payload for frame in frames.feed(right)] == ["1,2"]


def test_the_memory_of_a_reader_is_bounded():
    for start, most in ((COMMAND, LONGEST_COMMAND), (ANSWER, LONGEST_ANSWER)):
        frames = Frames(start)
        for piece in (start * 5000, b"x" * 100_000, start + b"y" * 100_000):
            frames.feed(piece)
            assert len(frames._rest) <= most + len(start)


@given(st.sampled_from(sorted(extension.COMMANDS)), st.text("0123456789,-+. eEnaif_٣\u00b2", max_size=80))
def test_a_payload_that_says_nothing_is_refused_with_a_sentence(letter, payload):
    try:
        command = extension.decode(Frame(letter, payload))
    except Malformed as error:
        assert str(error)
        return
    assert extension.decode(command.encode()) == command


@pytest.mark.parametrize(
    "command",
    [
        Claim(-1), Claim(2**53), Velocity(1, 1e308, 0.0, 0), Velocity(1, float("nan"), 0.0, 0),
        Velocity(1, float("inf"), 0.0, 0), Velocity(1, 0.0, 11.0, 0), Velocity(1, 0.0, 0.0, -1),
        Permit(1, 2**40 + 1, 0.1, (0, 0, 1, 1)), Permit(1, 1000, 0.1, (0, 0, float("nan"), 1)), Activate(1, 65536), Journal(-1),
    ],
)  # fmt: skip
def test_a_number_that_is_out_of_bounds_cannot_be_said(command):
    with pytest.raises(Malformed):
        extension.encode(command)


def test_a_permit_for_an_area_inside_out_is_refused():
    for payload in ("1,1000,100,5,0,4,1", "1,1000,100,0,5,1,4", "1,1000,-100,0,0,1,1"):
        with pytest.raises(Malformed):
            extension.decode(Frame("p", payload))


def test_what_fits_into_no_frame_is_refused():
    for frame in (Frame("c", "x" * 90), Frame("c", "\n"), Frame("c", "*"), Frame("", ""), Frame("7", ""), Frame("cc")):
        with pytest.raises(Malformed):
            frame.encode(COMMAND)
