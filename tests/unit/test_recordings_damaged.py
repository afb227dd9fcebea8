"""A recording that is cut off, damaged, empty, of other software, or in which the time of day was set: it replays as far as it goes."""

import json

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.writer import CompressionType, Writer

from robots.kit.contract.channels import Scalar
from robots.kit.contract.session import RobotState
from robots.kit.contract.streams import StreamPacket, pack
from robots.kit.packets import picture_packet, state_packet
from robots.kit.recording import reading
from robots.kit.recording.axis import LATE_NS, LONGEST_NS, Axis, words_of
from robots.kit.recording.container import COMMANDS, EVENTS, STATE, Tape
from robots.kit.recording.movie import cameras_of, chosen_pictures
from robots.kit.recording.packets import picture_of, state_told
from robots.kit.recording.reading import about, messages
from robots.kit.recording.timeline import HEAD, read_index, read_slice, slice_of

NAMES, CHANNELS = ("base", "elbow"), ["charge"]
BEGAN = 1_795_000_000_000  # ms
DAY = 86_400_000  # ms
JPEG = b"\xff\xd8" + bytes(range(256)) * 4 + b"\xff\xd9"
MANY = settings(
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow], max_examples=150, deadline=None
)


def write(path, times, flush_each=8):
    """Write a state, a picture and a stream's packet at each time (ms since `BEGAN`), an event at every tenth."""
    tape = Tape(path, {"robot": "mercury"})
    for n, ms in enumerate(times):
        at, robot = (BEGAN + ms) * 10**6, RobotState(0.0, (0.5, -1.0), (), True, True, values={"charge": 50.0})
        packet = state_packet(n, BEGAN + ms, robot, False, (Scalar("charge", "%", 0, 100),))
        tape.put(STATE, at, state_told(packet, NAMES, CHANNELS))
        tape.put(f"camera/{n % 2}", at, picture_of(picture_packet(n, BEGAN + ms, 7, (1.0,), JPEG, n % 2)))
        tape.put("stream/map", at, pack(StreamPacket(0, n, BEGAN + ms, n % 20 == 0, b"m")))
        if n % 10 == 0:
            tape.put(EVENTS, at, {"what": "notice", "text": f"Number {n}.", "level": "info"})
            tape.put(COMMANDS, at, {"id": n, "seq": 1, "kind": "up", "state": "queued"})
        if n % flush_each == flush_each - 1:
            tape.flush()
    tape.close()
    return path


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    return write(tmp_path_factory.mktemp("whole") / "a.mcap", range(0, 24_000, 500))


def in_order(found, of):
    """Tell whether `found` is what is left of `of` where parts are left out."""
    rest = iter(of)
    return all(one in rest for one in found)


def replayed(path):
    """Return the index, after each slice was read and taken apart as a browser does."""
    index, before = read_index(path), 0
    assert json.loads(json.dumps(index.events)) == index.events
    assert (
        len(index.needs) == len(index.places) == (slice_of(index.ended_ms - index.began_ms) + 1 if index.places else 0)
    )
    for number in range(len(index.needs)):
        data, at = read_slice(path, index, number, NAMES, CHANNELS), 0
        while at < len(data):
            length, ms = HEAD.unpack_from(data, at)
            assert slice_of(ms) == number and ms >= before, "time never goes back"
            before, at = ms, at + HEAD.size + length
        assert at == len(data)
    times = [told["after_ms"] for told in [*index.events, *index.commands]]
    assert all(0 <= ms <= index.ended_ms - index.began_ms for ms in times)
    return index


def judged(path, whole):
    """Fail unless all that can be read of a damaged file was in it, and a missing part is reported."""
    original, found = list(messages(whole)), list(messages(path))
    assert in_order(found, original)
    index = replayed(path)
    faults = [event["text"] for event in index.events if event["what"] == "fault"]
    if len(found) < len(original):
        assert faults
    if not found:
        assert index.end.startswith(reading.NOTHING)
    about(path)
    plan = {"hz": 5, "files": [(str(path), BEGAN)]}
    pictures = list(chosen_pictures(plan, cameras_of(plan)))
    assert len(pictures) == sum(m.topic.startswith("camera/") for m in found)
    return found, original, index


@MANY
@given(share=st.floats(0, 1))
def test_a_file_that_is_cut_off_anywhere_replays_up_to_there_and_says_so(whole, share):
    data = whole.read_bytes()
    cut = whole.with_suffix(".cut")
    cut.write_bytes(data[: int(share * len(data))])
    found, original, index = judged(cut, whole)
    assert found == original[: len(found)]
    if len(found) < len(original):
        assert reading.CUT in index.end and index.events[-1]["text"] == reading.CUT
        assert index.events[-1]["after_ms"] == index.ended_ms - index.began_ms


@MANY
@given(at=st.integers(0, 10**9), by=st.integers(1, 255))
def test_a_file_with_a_flipped_byte_loses_no_more_than_one_part(whole, at, by):
    data = bytearray(whole.read_bytes())
    data[at % len(data)] ^= by
    flipped = whole.with_suffix(".flip")
    flipped.write_bytes(data)
    found, original, _ = judged(flipped, whole)
    assert len(found) >= len(original) - 8 * 3 - 2


@MANY
@given(share=st.floats(0, 1), flips=st.lists(st.tuples(st.integers(0, 10**9), st.integers(1, 255)), max_size=6))
def test_a_file_that_is_cut_off_and_damaged_raises_nothing(whole, share, flips):
    data = bytearray(whole.read_bytes()[: int(share * len(whole.read_bytes()))])
    for at, by in flips if data else []:
        data[at % len(data)] ^= by
    both = whole.with_suffix(".both")
    both.write_bytes(data)
    assert in_order(list(messages(both)), list(messages(whole)))
    replayed(both)
    about(both)


@given(data=st.binary(max_size=300))
@MANY
def test_what_is_no_recording_is_an_empty_one_and_says_so(tmp_path, data):
    other = tmp_path / "b.mcap"
    other.write_bytes(data)
    assert list(messages(other)) == [] and about(other) == {}
    index = replayed(other)
    assert index.needs == [] and index.end.startswith(reading.NOTHING)


json_like = st.recursive(
    st.none() | st.booleans() | st.integers(-(10**20), 10**20) | st.floats() | st.text(max_size=5),
    lambda one: st.lists(one, max_size=3) | st.dictionaries(st.sampled_from(
        ["id", "kind", "state", "text", "level", "what", "mode", "joints", "values", "number", "moving", "stopped",
         "at_ms", "timestamp", "sec", "nsec", "data", "still"]), one, max_size=12),
    max_leaves=30,
)  # fmt: skip


@MANY
@given(told=st.lists(st.tuples(
    st.sampled_from([STATE, EVENTS, COMMANDS, "camera/0", "camera/x", "camera/٣", "stream/map", "other"]),
    st.integers(0, 2**64 - 1), json_like | st.binary(max_size=30)), max_size=12))  # fmt: skip
def test_a_recording_of_an_older_or_another_format_replays_what_is_understood(tmp_path, told):
    """As one without fields that came later: what has no meaning here is left out, and the rest is shown."""
    path = tmp_path / "old.mcap"
    with path.open("wb") as out:
        writer = Writer(out, compression=CompressionType.NONE, use_chunking=True)
        writer.start("older", "other software")
        channels = {topic: writer.register_channel(topic, "json", 0) for topic, _, _ in told}
        for topic, at, data in told:
            writer.add_message(channels[topic], at, data if isinstance(data, bytes) else json.dumps(data).encode(), 0)
        writer.finish()
    assert len(list(messages(path))) == len(told)
    replayed(path)
    plan = {"hz": 5, "files": [(str(path), BEGAN)]}
    list(chosen_pictures(plan, cameras_of(plan)))


@pytest.mark.parametrize("by", [DAY, -DAY, 3 * 3600_000, -60_000])
def test_where_the_time_of_day_was_set_the_player_goes_on_and_says_so(tmp_path, by):
    times = [ms + (by if ms >= 10_000 else 0) for ms in range(0, 20_000, 500)]
    path = write(tmp_path / "step.mcap", times)
    index = replayed(path)
    assert (index.began_ms, index.end) == (BEGAN, "")
    assert index.ended_ms - index.began_ms == 19_000, "one pause of half a second is not known"
    (said,) = [event for event in index.events if event["what"] == "fault"]
    assert said["text"] == words_of(by * 10**6) and said["after_ms"] == 9500
    assert ("ahead" if by > 0 else "back") in said["text"]
    plan = {"hz": 5, "files": [(str(path), BEGAN)]}
    shown = [at for at, _, _ in chosen_pictures(plan, cameras_of(plan))]
    assert shown == sorted(shown) and shown[-1] == 19_000
    lapse = plan | {"hz": 12, "every_s": 5}
    assert len(list(chosen_pictures(lapse, [0, 1]))) == 4


def test_a_time_lapse_goes_on_where_the_time_of_day_was_set_back_between_two_recordings(tmp_path):
    first, second = (write(tmp_path / f"{n}.mcap", range(0, 20_000, 500)) for n in (1, 2))
    plan = {"hz": 12, "every_s": 5, "files": [(str(first), BEGAN), (str(second), BEGAN - 10_000)]}
    assert len(list(chosen_pictures(plan, [0]))) == 8


@given(times=st.lists(st.integers(0, 2**63), max_size=50), cut=st.integers(0, 49))
def test_the_players_time_never_goes_back_and_can_be_taken_up_anywhere(times, cut):
    axis, found, taken_up = Axis(), [], None
    for n, at in enumerate(times):
        if n == cut:
            taken_up = Axis(axis.newest_ns, axis.at_ns)
        found.append(axis.place(at))
        assert axis.set_ns == 0 or not -LATE_NS <= axis.set_ns <= LONGEST_NS
        if taken_up is not None:
            assert taken_up.place(at) == found[-1]
    assert found == sorted(found)


@given(times=st.lists(st.integers(0, LONGEST_NS), min_size=1, max_size=30))
def test_a_clock_that_goes_evenly_is_the_players_time(times):
    axis, at, evenly = Axis(), 10**18, []
    for passed in times:
        at += passed
        evenly.append(axis.place(at))
    assert evenly == [sum(times[1 : n + 1]) for n in range(len(times))]


@pytest.mark.parametrize(
    ("set_ns", "words"),
    [
        (86_400, "ahead by about 1 day"),
        (-2 * 86_400, "back by about 2 days"),
        (7200, "ahead by about 2 hours"),
        (-60, "back by about 1 minute"),
    ],
)
def test_by_how_much_the_time_of_day_was_set_is_said_in_words(set_ns, words):
    assert words in words_of(set_ns * 10**9)
