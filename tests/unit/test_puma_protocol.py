"""The wire of the PUMA 560: whatever is written is read again, and nothing else is."""

from math import pi

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from robots.kit.arms.described import chain
from robots.kit.contract.compact import Layout
from robots.kit.contract.session import RobotState
from robots.kit.drivers.puma import protocol as wire
from robots.kit.drivers.puma.protocol import End, Error, Flag, Frame, Instruction, Mode, Receiver, Reply, State
from robots.kit.drivers.puma.spec import MODES, spec

MOTION = Frame(Instruction.JOINTS, 7, (123_456, 500, 15_000, 55_000, -85_000, 0, 40_000, 15_000))
WIDEST = {
    code: tuple(max(bounds, key=lambda one: len(str(one))) for bounds in ranges)
    for code, ranges in wire._RANGES.items()
}
frames = st.sampled_from(sorted(wire._RANGES)).flatmap(
    lambda code: st.builds(
        Frame, st.just(code), st.integers(0, 255), st.tuples(*(st.integers(*bounds) for bounds in wire._RANGES[code]))
    )
)
states = st.builds(
    State, st.integers(0, 65_535), st.integers(0, wire.CLOCK - 1), st.sampled_from(Mode), st.integers(0, 7).map(Flag),
    st.integers(0, 255), st.integers(0, 255), st.sampled_from(End), st.sampled_from(Error),
    st.tuples(*[st.floats(-4 * pi, 4 * pi)] * 6),
)  # fmt: skip


def read(data, known=wire.INSTRUCTIONS | wire.REPLIES):
    receiver = Receiver(known)
    return receiver.feed(data), receiver.broken


@given(st.lists(frames, max_size=5), st.integers(1, 40))
def test_what_was_written_is_read_in_parts_of_any_size(written, size):
    data, receiver = b"".join(frame.encode() for frame in written), Receiver(wire.INSTRUCTIONS)
    found = [frame for at in range(0, len(data), size) for frame in receiver.feed(data[at : at + size])]
    assert found == written
    assert [frame.checked() for frame in found] == [frame.numbers for frame in written]
    assert receiver.broken == 0


@pytest.mark.parametrize("code", sorted(wire._RANGES))
def test_no_line_is_longer_than_a_receiver_takes(code):
    data = Frame(code, 255, WIDEST[code]).encode()
    assert len(data) <= wire.LONGEST
    assert read(data)[0][0].checked() == WIDEST[code]


@given(st.binary(max_size=400))
@example(b":" * 300)
@example(b":1 2" + b"9" * 5000 + b"\n")
@example(b":10 1 *\n:10 1 *0000\n:-1 1 *1021\n")
@example(b":10 999999999999999999999 *ABCD\n")
def test_any_bytes_before_a_hold_do_not_hide_it(noise):
    hold = Frame(Instruction.HOLD, 9)
    found, _ = read(noise + hold.encode())
    assert found[-1] == hold


@given(frames, st.data())
def test_a_spoilt_byte_is_never_another_instruction(frame, data):
    line = bytearray(frame.encode())
    at = data.draw(st.integers(0, len(line) - 1))
    line[at] ^= data.draw(st.integers(1, 255))
    asked = []
    found = Receiver(wire.INSTRUCTIONS | wire.REPLIES, asked.append).feed(bytes(line))
    assert found in ([], [frame])  # a line feed that became another one ends nothing; nothing else is the same
    assert set(asked) <= set(range(256))


@given(frames, st.integers(0, 15), st.integers(-(10**8), 10**8))
def test_a_number_out_of_its_bounds_is_refused_where_it_is_read(frame, at, number):
    if at >= len(frame.numbers):
        with pytest.raises(wire.FormError):
            Frame(frame.id, frame.seq, (*frame.numbers, number)).checked()
        return
    low, high = wire._RANGES[frame.id][at]
    changed = Frame(frame.id, frame.seq, (*frame.numbers[:at], number, *frame.numbers[at + 1 :]))
    if low <= number <= high:
        assert changed.checked()[at] == number
    else:
        with pytest.raises(wire.FormError):
            changed.checked()


@given(states, st.integers(0, 255))
def test_a_state_is_told_to_a_thousandth_of_a_degree(state, seq):
    (frame,), _ = read(state.frame(seq).encode())
    again = State.of(frame)
    assert again.joints == pytest.approx(state.joints, abs=pi / 180 / 1000 / 2 + 1e-12)
    assert (again.mode, again.flags, again.end, again.why) == (state.mode, state.flags, state.end, state.why)
    assert wire.kind_of(frame) == "state"
    assert wire.spell(frame).startswith(f"STATE #{seq} {state.boot}")


@pytest.mark.parametrize(
    "reply", [Frame(Reply.STATE, 1, (1,) * 13), Frame(Reply.NAK, 1, (1, 1, 99)), Frame(Reply.ACK, 1)]
)
def test_a_reply_with_impossible_numbers_is_none(reply):
    with pytest.raises(ValueError):
        wire.kind_of(reply)


def test_a_state_with_an_unknown_mode_is_none():
    assert wire.state_of(Frame(Reply.STATE, 1, (1,) * 14)).mode == Mode.PLANNING
    with pytest.raises(ValueError, match="77"):
        wire.state_of(Frame(Reply.STATE, 1, (1, 1, 77, *(1,) * 11)))


@pytest.mark.parametrize(
    ("latest", "clock", "late"),
    [(100, 100, False), (100, 101, True), (100, 99, False), (5, wire.CLOCK - 5, False), (wire.CLOCK - 5, 5, True)],
)
def test_the_clock_goes_in_a_circle(latest, clock, late):
    assert wire.too_late(latest, clock) is late


def test_a_refusal_says_why_and_a_spoilt_line_is_asked_for_again():
    assert wire.refusal_of(Frame(Reply.NAK, 1, (1, 1, Error.TOO_LATE))) == "the instruction came too late"
    assert wire.refusal_of(Frame(Reply.ACK, 1, (1, 1))) == ""
    assert wire.kind_of(Frame(Reply.NAK, 1, (1, 1, Error.CHECKSUM))) == "resend"
    assert wire.kind_of(MOTION) == "other"


def test_a_state_takes_17_bytes_and_tells_the_tool_to_0_03_mm():
    layout, arm = Layout.of(spec()), chain("puma")
    assert layout is not None
    assert layout.size <= 19
    dice = np.random.default_rng(1)
    worst = 0.0
    for q in dice.uniform(arm.low, arm.high, (2000, 6)):
        packet = layout.encode(5, RobotState(0.0, tuple(q), (), True, True, mode=MODES[2]), False, {"valve": 1.0})
        told, _ = layout.decode(packet, 5)
        worst = max(worst, float(np.linalg.norm((arm.forward(q) - arm.forward(np.array(told.joints)))[:3, 3])))
    assert worst < 3e-5
