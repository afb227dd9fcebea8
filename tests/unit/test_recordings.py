"""The file of a recording: what goes in comes out, also of a file that was cut off anywhere; budget and time index."""

import json
import math
from dataclasses import dataclass

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader

from robots.kit.contract.channels import Scalar
from robots.kit.contract.session import RobotState
from robots.kit.contract.streams import StreamPacket, pack
from robots.kit.packets import picture_packet, state_packet
from robots.kit.recording.budget import picture_every_s
from robots.kit.recording.container import COMMANDS, EVENTS, STATE, Message, Tape
from robots.kit.recording.packets import picture_of, picture_packed, state_packed, state_told
from robots.kit.recording.reading import about, messages
from robots.kit.recording.timeline import HEAD, SLICE_MS, needed_slices, read_index, read_slice, slice_of

NAMES, CHANNELS = ("base", "elbow"), ["charge", "x"]
BEGAN = 1_795_000_000_000  # ms
JPEG = b"\xff\xd8" + bytes(range(256)) * 40 + b"\xff\xd9"
floats = st.floats(width=32, allow_nan=True, allow_infinity=False)


def same(a, b):
    return a == b or (math.isnan(a) and math.isnan(b))


def state(at_ms, number=1, joints=(0.5, -1.0)):
    return state_packet(
        number, at_ms, RobotState(0.0, joints, (), True, True, mode="driving", values={"charge": 50.0}), False,
        (Scalar("charge", "%", 0, 100), Scalar("x", "m", -9, 9)),
    )  # fmt: skip


@dataclass
class Written:
    path: object
    put: list


@pytest.fixture
def written(tmp_path):
    """Twenty-three seconds of a robot: states, pictures of two cameras, a stream, two commands, an event."""
    tape = Tape(tmp_path / "a.mcap", {"robot": "mercury"})
    count = 0
    for ms in range(0, 23_000, 250):
        at = (BEGAN + ms) * 1_000_000
        tape.put(STATE, at, state_told(state(BEGAN + ms, ms // 250), NAMES, CHANNELS), at)
        camera = ms // 250 % 2
        tape.put(f"camera/{camera}", at, picture_of(picture_packet(ms, BEGAN + ms, 7, (1.0,), JPEG, camera)), at)
        key = ms in (0, 12_000)
        tape.put("stream/map", at, pack(StreamPacket(0, ms // 250, BEGAN + ms, key, b"m" * 20)))
        if ms == 6000:
            tape.put(COMMANDS, at, {"id": 4, "kind": "up", "state": "queued"})
        count += 3
        if ms % 2000 == 0:
            tape.flush()
    tape.put(EVENTS, at, {"what": "notice", "text": "The end.", "level": "info"})
    tape.close()
    return Written(tmp_path / "a.mcap", count + 2)


def test_what_is_put_in_comes_out_and_other_programs_read_it(written):
    found = list(messages(written.path))
    assert len(found) == written.put
    assert [m.at_ns for m in found] == sorted(m.at_ns for m in found)
    assert about(written.path) == {"robot": "mercury"}
    with written.path.open("rb") as file:
        summary = make_reader(file).get_summary()
    named = {
        channel.topic: summary.schemas[channel.schema_id].name
        for channel in summary.channels.values()
        if channel.schema_id
    }
    assert named == {
        "state": "farhand.State", "commands": "farhand.Command", "events": "farhand.Event",
        "camera/0": "foxglove.CompressedImage", "camera/1": "foxglove.CompressedImage",
    }  # fmt: skip
    picture = next(m for m in found if m.topic == "camera/1").content()
    assert {"timestamp", "frame_id", "data", "format"} <= picture.keys() and picture["format"] == "jpeg"


@settings(
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow], max_examples=60, deadline=None
)
@given(share=st.floats(0, 1))
def test_a_file_that_was_cut_off_anywhere_is_readable_up_to_its_last_whole_chunk(written, share):
    data = written.path.read_bytes()
    cut = written.path.with_suffix(".cut")
    cut.write_bytes(data[: int(share * len(data))])
    whole = [m.data for m in messages(written.path)]
    found = [m.data for m in messages(cut)]
    assert found == whole[: len(found)]
    if share > 0.5:
        assert len(found) > len(whole) * 0.25


def test_a_disk_that_refuses_leaves_a_file_that_is_readable(tmp_path):
    tape = Tape(tmp_path / "c.mcap", {})
    for n in range(100):
        tape.put(STATE, n, {"number": n})
    tape.flush()
    whole = tape.whole
    tape._out.write(b"half a chunk")  # what a full disk leaves
    tape._out.flush()
    tape.abandon()
    assert (tmp_path / "c.mcap").stat().st_size == whole
    assert [m.content()["number"] for m in messages(tmp_path / "c.mcap")] == [*range(100)]


@given(
    joints=st.lists(floats, max_size=7), rows=st.sampled_from([1, 3]), values=st.lists(floats, min_size=2, max_size=2),
    number=st.integers(0, 2**32 - 1), mode=st.text(max_size=8).filter(lambda t: t.isprintable()),
)  # fmt: skip
def test_a_state_survives_without_a_change(joints, rows, values, number, mode):
    told = RobotState(
        0.0, tuple(joints), (), True, True, mode=mode, values=dict(zip(CHANNELS, values, strict=True)),
        **({"velocities": tuple(joints), "torques": tuple(joints)} if rows == 3 else {}),
    )  # fmt: skip
    packet = state_packet(number, BEGAN, told, True, (Scalar("charge", "%", 0, 100), Scalar("x", "m", -9, 9)))
    kept = json.loads(json.dumps(state_told(packet, NAMES, CHANNELS)))
    assert state_packed(kept, NAMES, CHANNELS) == packet


def test_a_recorded_state_tells_the_velocity_of_the_body_beside_its_channels():
    told = RobotState(0.0, (), (), True, True, values={"charge": 50.0, "x": 1.0})
    channels = (Scalar("charge", "%", 0, 100), Scalar("x", "m", -9, 9))
    packet = state_packet(1, BEGAN, told, False, channels, twist=(0.5, math.nan))
    kept = json.loads(json.dumps(state_told(packet, (), CHANNELS)))
    assert (kept["values"], kept["twist"]) == ({"charge": 50.0, "x": 1.0}, [0.5, None])
    assert state_packed(kept, (), CHANNELS) == packet


@given(
    jpeg=st.binary(max_size=200),
    still=st.integers(0, 2**32 - 1),
    camera=st.integers(0, 7),
    joints=st.lists(floats.filter(math.isfinite), max_size=7),
)
def test_a_picture_survives_without_a_change(jpeg, still, camera, joints):
    packet = picture_packet(9, BEGAN, still, tuple(joints), jpeg, camera)
    kept = json.loads(json.dumps(picture_of(packet)))
    assert picture_packed(kept, camera) == packet


@pytest.mark.parametrize("data", [b"", b"\x01", b"\x02" * 30, bytes(16), b"\x01\x04" + bytes(14)])
def test_what_is_no_state_is_refused(data):
    with pytest.raises(ValueError, match="state"):
        state_told(data, NAMES, CHANNELS)


@given(used=st.integers(0, 10**9), more=st.integers(0, 10**9), limit=st.integers(1, 10**9), cameras=st.integers(1, 8))
def test_pictures_become_rarer_as_the_file_grows_and_end_before_its_limit(used, more, limit, cameras):
    assert picture_every_s(used, limit, cameras) <= picture_every_s(used + more, limit, cameras)
    assert picture_every_s(limit, limit, cameras) == math.inf
    assert picture_every_s(0, limit, 1) == 0.2


@given(tracks=st.lists(st.lists(st.integers(0, 59_999)), max_size=4))
def test_a_slice_names_the_earliest_that_it_needs(tracks):
    slices = 12
    needs = needed_slices(tracks, slices)
    for number, first in enumerate(needs):
        assert 0 <= first <= number
        for times in tracks:
            before = [at for at in times if at <= number * SLICE_MS]
            if before:  # the newest beginning lies in the part that is read
                assert slice_of(max(before)) >= first
    assert needed_slices([], 3) == [0, 1, 2]


def test_the_index_and_the_slices_tell_everything_once(written):
    index = read_index(written.path)
    assert (index.began_ms, index.ended_ms) == (BEGAN, BEGAN + 22_750)
    assert index.cameras == [0, 1] and index.pictures == 92
    assert index.needs == [0, 0, 0, 2, 2], "the map's second key packet came in the third slice"
    assert [(c["kind"], c["after_ms"]) for c in index.commands] == [("up", 6000)]
    assert [e["text"] for e in index.events] == ["The end."]
    kinds, times = [], []
    for number in range(len(index.needs)):
        data, at = read_slice(written.path, index, number, NAMES, CHANNELS), 0
        while at < len(data):
            length, ms = HEAD.unpack_from(data, at)
            kinds.append(data[at + HEAD.size])
            times.append(ms)
            assert slice_of(ms) == number
            at += HEAD.size + length
    assert (kinds.count(1), kinds.count(2), kinds.count(3)) == (92, 92, 92)
    assert times == sorted(times)
    assert read_slice(written.path, index, 99, NAMES, CHANNELS) == b""


def test_an_empty_recording_has_an_index_too(tmp_path):
    Tape(tmp_path / "d.mcap", {}).close()
    assert read_index(tmp_path / "d.mcap").needs == []


def test_messages_are_copied_as_they_are(tmp_path, written):
    tape = Tape(tmp_path / "e.mcap", {})
    for message in messages(written.path):
        tape.copy(message)
    tape.close()
    assert list(messages(tmp_path / "e.mcap")) == list(messages(written.path))
    assert isinstance(next(messages(written.path)), Message)
