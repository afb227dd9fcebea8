"""The writer of one recording: it takes what comes without waiting, leaves out what the disk cannot take, and ends by itself."""

import json
import threading
from types import SimpleNamespace

import pytest

from robots.kit.clock import SYSTEM
from robots.kit.contract.session import RobotState
from robots.kit.contract.streams import Stream, StreamPacket, pack
from robots.kit.packets import CommandStage, picture_packet, state_packet
from robots.kit.recording.container import Tape
from robots.kit.recording.reading import messages
from tests.conftest import wait_for
from workers.recorder.recorder import Recorder
from workers.recorder.taping import FLUSH_S, Taping

SPEC = SimpleNamespace(joints=("base",), packed=lambda: (), carried=lambda: (), streams=(Stream("map"),))
JPEG = bytes(range(256)) * 80
S = 10**9


def taping(path, limit=64_000_000, room=lambda: True, cameras=1):
    return Taping(path, {"robot": "m"}, SPEC, cameras, limit, room)


def state(n):
    return state_packet(n, n * 100, RobotState(0.0, (float(n),), (), False, True), False)


def picture(n):
    return picture_packet(n, n * 100, 0, (), JPEG)


def ended(one):
    one.close()
    wait_for(one.written.is_set, 60, "the end of the recording")
    return one.end


def topics(path):
    return [m.topic for m in messages(path)]


def test_pictures_are_thinned_and_everything_else_is_kept(tmp_path):
    one = taping(tmp_path / "a.mcap")
    for n in range(100):  # ten seconds
        one.state(n * S // 10, state(n))
        one.picture(0, n * S // 10, picture(n))
    one.stream(0, pack(StreamPacket(0, 1, 0, True, b"map")))
    one.stream(0, pack(StreamPacket(7, 1, 0, True, b"of no stream")))
    one.stream(0, b"nothing")
    one.state(0, b"no state")
    assert ended(one).whole
    found = topics(tmp_path / "a.mcap")
    assert (found.count("state"), found.count("camera/0"), found.count("stream/map")) == (100, 50, 1)
    assert not (tmp_path / "a.tape").exists()


def test_a_still_is_never_thinned_out(tmp_path):
    one = taping(tmp_path / "s.mcap")
    for n, still in enumerate([0, 0, 41, 41, 41, 42, 0]):  # seven pictures in 70 ms
        one.picture(0, n * S // 100, picture_packet(n, n, still, (), JPEG))
    one.picture(0, S, b"\x02")
    assert ended(one).whole
    told = [m.content() for m in messages(tmp_path / "s.mcap") if m.topic == "camera/0"]
    assert [(t["number"], t["still"]) for t in told] == [(0, 0), (2, 41), (5, 42)]


def test_a_disk_that_hangs_blocks_nobody_and_what_is_left_out_is_counted(tmp_path):
    hangs, free, freed = threading.Event(), threading.Event(), threading.Event()

    def room():
        hangs.set()
        free.wait()  # the writer's thread hangs here, as in a write
        freed.set()
        return True

    one = taping(tmp_path / "b.mcap", room=room)
    one.state(10 * S, state(0))
    wait_for(hangs.is_set, 60, "the disk hangs")
    for n in range(2000):
        one.picture(0, (11 + n) * S, picture(n))
        one.state((11 + n) * S, state(n))
    assert not freed.is_set(), "nobody waited"
    free.set()
    end = ended(one)
    found = topics(tmp_path / "b.mcap")
    assert end.dropped > 1000 and found.count("camera/0") + end.dropped == 2000
    assert found.count("state") == 2001, "states came through: pictures are left out first"


def test_a_recording_ends_at_its_greatest_size_and_says_so(tmp_path):
    one = taping(tmp_path / "c.mcap", limit=1_000_000)
    for n in range(3000):
        one.picture(0, n * S, picture(n))
        one.state(n * S, state(n))
        one.stream(n * S, pack(StreamPacket(0, n, 0, True, JPEG)))
        SYSTEM.sleep(0.0002)
    end = ended(one)
    assert not end.whole and "greatest size" in end.reason
    assert (tmp_path / "c.mcap").stat().st_size < 1_300_000
    told = [m.content()["text"] for m in messages(tmp_path / "c.mcap") if m.topic == "events"]
    assert any("Pictures from now on" in text for text in told)


def test_a_disk_without_room_ends_it_and_what_was_recorded_stays(tmp_path):
    rooms = iter([True, True, False])
    one = taping(tmp_path / "d.mcap", room=lambda: next(rooms, False))
    for n in range(10):
        one.state(int(n * FLUSH_S * S), state(n))
        SYSTEM.sleep(0.02)
    end = ended(one)
    assert not end.whole and "no room" in end.reason
    assert len(topics(tmp_path / "d.mcap")) >= 2


@pytest.mark.parametrize("place", ["/proc/nowhere/e.mcap", "/dev/null/e.mcap"])
def test_a_place_that_cannot_be_written_ends_it_with_a_reason(place):
    from pathlib import Path

    one = taping(Path(place))
    wait_for(one.written.is_set, 5, "the end")
    one.state(0, state(0))
    assert not one.end.whole and "could not be written" in one.end.reason


def test_what_a_killed_recorder_left_is_gone_on_with(tmp_path):
    tape = Tape(tmp_path / "f.tape", {})
    for n in range(50):
        tape.put("state", n * S, {"number": n})
    tape.flush()
    tape._out.write(b"\x06half")  # killed in the middle of a write
    tape._out.close()
    one = taping(tmp_path / "f.mcap")
    one.state(60 * S, state(60))
    assert "interrupted" in ended(one).reason
    assert [m.content().get("number", "gap") for m in messages(tmp_path / "f.mcap")] == [*range(50), "gap", 60]
    assert [p.name for p in tmp_path.iterdir()] == ["f.mcap"]


def test_a_recorder_that_is_killed_while_it_goes_on_loses_nothing(tmp_path):
    tape = Tape(tmp_path / "g.old", {})
    for n in range(5):
        tape.put("state", n * S, {"number": n})
    tape.close()
    (tmp_path / "g.tape").write_bytes(b"a copy that was cut off")
    ended(taping(tmp_path / "g.mcap"))
    assert [m.content().get("number", "gap") for m in messages(tmp_path / "g.mcap")] == [*range(5), "gap"]
    assert [p.name for p in tmp_path.iterdir()] == ["g.mcap"]


def test_the_end_of_a_command_is_recorded_once():
    """The recorder learns of an end twice: from the row, and later from the bus."""
    kept = []
    one = SimpleNamespace(
        stages={7: "queued"}, taping=SimpleNamespace(tell=lambda topic, at_ns, data: kept.append(data))
    )
    recorder = Recorder()
    for state in ("acknowledged", "completed", "accepted", "acknowledged", "completed"):
        recorder._tell_command(one, CommandStage(7, 1, 3, "up", state))
    assert [json.loads(data)["state"] for data in kept] == ["acknowledged", "completed"]
