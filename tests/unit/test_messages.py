import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots import messages
from robots.messages import Changed, CommandStage, Notice, Trace


@given(st.tuples(*[st.floats(-3.2, 3.2)] * 4), st.booleans(), st.booleans(), st.integers(0, 2**40))
def test_a_state_packet_is_a_few_dozen_bytes_and_keeps_a_tenth_of_a_millirad(joints, moving, latched, at):
    packet = messages.state_packet(3, at, joints, moving, latched)
    assert len(packet) == 22
    kind, flags, _, at_ms, *scaled = messages.STATE_PACKET.unpack(packet)
    assert (kind, flags & 1, flags >> 1, at_ms) == (1, moving, latched, at)
    for a, b in zip(scaled, joints, strict=True):
        assert abs(a / 10_000 - b) < 6e-5


@pytest.mark.parametrize(
    "event", [Changed("queue"), Notice("hello"), CommandStage(1, 2, 3, "up", "sent"), Trace(">", "01", "x", 5)]
)
def test_events_survive_the_bus(event):
    assert messages.decode(messages.encode(event)) == event


@pytest.mark.parametrize("data", [b"{}", b'{"t":"changed"}', b'{"t":"changed","what":"x","more":1}', b"\xff", b'{"t":"nope"}'])  # fmt: skip
def test_unknown_fields_and_messages_are_refused(data):
    with pytest.raises(msgspec.MsgspecError):
        messages.decode(data)
