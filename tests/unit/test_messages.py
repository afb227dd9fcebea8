import struct

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.kit import packets as messages
from robots.kit.contract.session import RobotState
from robots.kit.packets import Changed, CommandStage, Notice, Trace


@given(
    st.lists(st.floats(-400, 400, width=32), min_size=1, max_size=9), st.booleans(), st.booleans(), st.booleans(),
    st.integers(0, 2**40), st.sampled_from(["", "KIN RPY CTRL", "größer"]),
)  # fmt: skip
def test_a_state_packet_carries_any_number_of_joints(joints, more, moving, latched, at, mode):
    row = tuple(joints)
    state = RobotState(0.0, row, (), moving, True, "", row[::-1] if more else (), row if more else (), mode)
    packet = messages.state_packet(3, at, state, latched)
    kind, flags, number, at_ms, count, rows = messages.STATE_HEAD.unpack_from(packet)
    assert (kind, flags & 1, flags >> 1, number, at_ms) == (1, moving, latched, 3, at)
    end = messages.STATE_HEAD.size + 4 * count * rows
    values = struct.unpack(f"<{count * rows}f", packet[messages.STATE_HEAD.size : end])
    assert values == (row + row[::-1] + row if more else row)
    assert packet[end:].decode() == mode


@given(st.integers(0, 7), st.lists(st.floats(-10, 10, width=32), max_size=9), st.binary(min_size=1))
def test_a_picture_packet_says_which_camera_took_it(camera, joints, jpeg):
    packet = messages.picture_packet(9, 5, 77, tuple(joints), jpeg, camera)
    head = messages.PICTURE_HEAD.unpack_from(packet)
    assert head == (2, camera, 9, 5, 77, len(joints))
    assert packet[messages.PICTURE_HEAD.size + 4 * len(joints) :] == jpeg


@pytest.mark.parametrize(
    "event", [Changed("queue"), Notice("hello"), CommandStage(1, 2, 3, "up", "sent"), Trace(">", "01", "x", 5)]
)
def test_events_survive_the_bus(event):
    assert messages.decode(messages.encode(event)) == event


@pytest.mark.asvs("1.5.2", "15.3.3")
@pytest.mark.parametrize("data", [b"{}", b'{"t":"changed"}', b'{"t":"changed","what":"x","more":1}', b"\xff", b'{"t":"nope"}'])  # fmt: skip
def test_unknown_fields_and_messages_are_refused(data):
    with pytest.raises(msgspec.MsgspecError):
        messages.decode(data)
