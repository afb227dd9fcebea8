"""What a recording contains from its first moment on."""

from datetime import timedelta
from math import inf

import pytest

from robots import bus, services
from robots.grants import end_grant
from robots.kit.clock import SYSTEM
from robots.kit.contract.streams import StreamPacket, pack, unpack
from robots.kit.recording.timeline import HEAD, read_index, read_slice
from robots.models import Command, Recording, RecordingState, Records, Robot
from robots.recordings import keeping
from robots.states import GrantEnd, GrantKind, Lane
from workers.recorder.recorder import Recorder

# ruff: noqa: TID251 - its tests are timed
pytestmark = [
    pytest.mark.service,
    pytest.mark.django_db,
    pytest.mark.parametrize("which", ["irat"], indirect=True),
    pytest.mark.timed,
]


class SlowClock:
    """The machine's clock, of a machine that takes 5 ms for everything."""

    monotonic, sleep = staticmethod(SYSTEM.monotonic), staticmethod(SYSTEM.sleep)

    def __init__(self):
        self._late = timedelta()

    def now(self):
        self._late += timedelta(milliseconds=5)
        return SYSTEM.now() + self._late


@pytest.fixture
def turn(robot, people, owned, redis_server, settings, tmp_path):
    """A turn with a command, on a robot whose map is known already."""
    settings.MEDIA_ROOT = tmp_path
    settings.RECORDING = settings.RECORDING | {"FREE_MB": 0}
    bus.connection().flushall()
    Robot.objects.update(records=Records.WORK)
    now = SYSTEM.now()
    grant = services.start_grant(robot, GrantKind.TURN, now, people["ada"], now + timedelta(minutes=5))
    Command.objects.create(
        robot=robot, grant=grant, kind="drive", lane=Lane.MOTION, client_seq=1, epoch=5, issued_by=people["ada"],
        deadline=now + timedelta(seconds=9), created_at=now,
    )  # fmt: skip
    return grant


def kept(stream, number, key, data):
    bus.publish_stream("irat", stream, [pack(StreamPacket(stream, number, 1000 + number, key, data))], key)


def recorded(seconds=5):
    """Record until a part was written; return what a page is given of the first slice."""
    recorder, until = Recorder(SlowClock(), "here"), SYSTEM.monotonic() + seconds
    recorder.run(lambda: bool(recorder.running) or SYSTEM.monotonic() > until)
    row = Recording.objects.get()
    assert row.state == RecordingState.RUNNING
    path = keeping.live_path(row)
    return given(path)


def given(path):
    data, found, at = read_slice(path, read_index(path), 0, (), ()), [], 0
    while at < len(data):
        length, ms = HEAD.unpack_from(data, at)
        found.append((ms, data[at + HEAD.size : at + HEAD.size + length]))
        at += HEAD.size + length
    return found


def test_the_map_that_was_known_before_is_there_from_the_first_moment_on(turn):
    kept(0, 7, True, b"map")
    kept(0, 8, False, b"a place more")
    kept(1, 3, True, b"cells")
    found = [(ms, unpack(data)) for ms, data in recorded() if data[0] == 3]
    assert [(ms, p.stream, p.number, p.data) for ms, p in found] == [
        (0, 0, 7, b"map"), (0, 0, 8, b"a place more"), (0, 1, 3, b"cells"),
    ]  # fmt: skip


def test_what_a_broken_link_has_hidden_of_the_map_is_read_when_it_is_back(turn):
    kept(0, 7, True, b"map")
    recorder, broken, back = Recorder(SlowClock(), "here"), [], []

    def listening():
        return {one["id"] for one in bus.connection().client_list(_type="pubsub")}

    channel, until = bus.stream_channel("irat"), SYSTEM.monotonic() + 8

    def over():
        if recorder.running and not broken:
            broken.extend(listening())
            bus.connection().client_kill_filter(_type="pubsub")
            kept(0, 8, False, b"not heard")
            return False
        if broken and listening() - set(broken) and bus.connection().pubsub_numsub(channel)[0][1]:
            back.append(True)
        return bool(back) or SYSTEM.monotonic() > until

    recorder.run(over)
    path = keeping.live_path(Recording.objects.get())
    numbers = [unpack(data).number for _, data in given(path) if data[0] == 3]
    assert numbers == [7, 7, 8]


def test_a_recording_that_ends_beside_the_next_of_the_same_robot_leaves_that_one_its_ears(turn, people):
    """The command of the first is not final when its grant ends, so it is recorded for a while beside the second."""
    recorder, steps, until = Recorder(SlowClock(), "here"), [], SYSTEM.monotonic() + 60

    def over():
        if not steps and recorder.running:
            now = SYSTEM.now()
            Command.objects.update(state="acknowledged")
            end_grant(turn, GrantEnd.HOLDER, "over", now)
            services.start_grant(turn.robot, GrantKind.TURN, now, people["bob"], now + timedelta(minutes=5))
            steps.append("second")
        elif steps == ["second"] and len(recorder.running) == 2:
            Command.objects.update(state="completed")
            steps.append("both")
        elif steps == ["second", "both"] and len(recorder.running) == 1:
            kept(0, 9, True, b"after")
            steps.append("one")
        elif "one" in steps:
            steps.append("heard")  # each time it has listened before
        return steps.count("heard") > 2 or SYSTEM.monotonic() > until

    recorder.run(over)
    assert "heard" in steps, steps
    path = keeping.live_path(Recording.objects.get(grant__holder=people["bob"]))
    assert 9 in [unpack(data).number for _, data in given(path) if data[0] == 3]


def test_no_more_pictures_are_asked_for_than_the_recording_takes(turn, monkeypatch):
    """As the file grows it takes fewer, then none: the robot's cameras are not kept busy for it."""
    recorder, asked = Recorder(SYSTEM, "here"), []
    recorder.run(lambda: bool(recorder.running))
    one = recorder.running[turn.pk]
    monkeypatch.setattr(bus, "watch", lambda slug, what: asked.append(what))
    for every_s, what in ((0.2, "frames.some"), (1.6, "frames.slow"), (25.6, "frames.rare"), (inf, None)):
        asked.clear()
        one.taping.every_s = every_s
        recorder.ask(one)
        assert asked[:1] == ([what] if what else [])
