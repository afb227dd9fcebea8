from hypothesis import given
from hypothesis import strategies as st

from robots.kit.drivers.mercury import protocol as wire
from robots.kit.drivers.mercury.protocol import Flag, Frame, Instruction, Mode, Receiver, Reply

frames = st.builds(Frame, st.sampled_from(list(map(int, Instruction))), st.integers(0, 255), st.binary(max_size=40))


@given(st.lists(frames, max_size=6), st.integers(1, 7))
def test_frames_come_out_as_they_went_in_however_the_bytes_are_cut(sent, size):
    data = b"".join(f.encode() for f in sent)
    receiver = Receiver(wire.INSTRUCTIONS)
    got = []
    for i in range(0, len(data), size):
        got += receiver.feed(data[i : i + size], i * 1e-4)
    assert got == sent
    assert receiver.broken == 0


@given(frames, st.data())
def test_a_spoilt_frame_is_never_taken_for_another(frame, data):
    spoilt = bytearray(frame.encode())
    for _ in range(data.draw(st.integers(1, 4))):
        i = data.draw(st.integers(0, len(spoilt) - 1))
        spoilt[i] ^= data.draw(st.integers(1, 255))
    for got in Receiver(wire.INSTRUCTIONS).feed(bytes(spoilt), 0.0):
        assert got == frame


@given(frames, frames, st.integers(0, 50))
def test_a_lost_byte_costs_its_frame_only(first, second, at):
    data = bytearray(first.encode())
    del data[at % len(data)]
    receiver = Receiver(wire.INSTRUCTIONS)
    receiver.feed(bytes(data), 0.0)
    assert receiver.feed(second.encode(), wire.GAP_S + 0.01)[-1:] == [second]


@given(st.tuples(*[st.floats(-1000, 1000, width=32)] * 4), st.sampled_from(list(Mode)), st.integers(0, 3))
def test_state_survives_the_wire(joints, mode, flags):
    state = wire.ControllerState(7, mode, Flag(flags), 42, joints)
    assert wire.unpack_state(wire.pack_state(3, state).payload) == state


def test_the_exact_bytes_of_a_move():
    frame = wire.move_xyz(9, 100.0, -20.5, 0.0)
    assert frame.encode().hex(" ") == "01 0d 09 00 00 c8 42 00 00 a4 c1 00 00 00 00 " + frame.encode()[-4:].hex(" ")
    assert len(frame.encode()) == 19
    assert frame.id == Instruction.MOVE_XYZ


def test_sequence_numbers_are_compared_round_the_corner():
    assert wire.newer(1, 255)
    assert wire.newer(5, 4)
    assert not wire.newer(4, 4)
    assert not wire.newer(250, 3)


def test_an_end_carries_the_joints():
    frame = wire.pack_end(Reply.DONE, 4, 1, (1.0, 2.0, 3.0, 4.0))
    assert wire.unpack_end(frame.payload) == (1.0, 2.0, 3.0, 4.0)
