"""The recorder as a process: a turn is recorded, and whatever becomes of the recorder, the robot works on."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from robots import bus, services
from robots.grants import end_grant
from robots.kit.clock import SYSTEM
from robots.kit.recording.reading import messages
from robots.models import Recording, RecordingState, Records, Robot
from robots.recordings import keeping
from robots.states import GrantEnd
from tests.conftest import wait_for
from tests.rig import Child

# ruff: noqa: TID251 - its tests are timed
pytestmark = pytest.mark.timed

RECORD = [sys.executable, "-m", "workers.recorder"]


@pytest.fixture
def recorder(rig):
    """Start a recorder; `again` begins another."""
    Robot.objects.update(records=Records.WORK)
    started = []

    def begin(argv=RECORD, **env):
        started.append(Child("recorder", argv, **{"FARHAND_RECORDING_FREE_MB": "1", **env}))
        return started[-1]

    yield begin
    for child in started:
        if child.alive():
            child.kill()


@pytest.fixture
def small_disk(tmp_path, settings):
    """A folder for pictures and recordings with 64 kB."""
    tmp_path.chmod(0o755)
    mount = ["mount", "-t", "tmpfs", "-o", "size=64k", "none", str(tmp_path)]
    if subprocess.run(mount, capture_output=True, check=False).returncode:
        pytest.skip("mounting a tmpfs needs root")
    settings.MEDIA_ROOT = tmp_path
    yield tmp_path
    subprocess.run(["umount", "--lazy", str(tmp_path)], capture_output=True, check=False)


def recording():
    return Recording.objects.filter().first()


def running():
    row = recording()
    return row is not None and keeping.live_path(row).exists()


def ended(rig):
    """End the turn; return its recording once it is finished."""
    end_grant(services.open_grant(Robot.objects.get(pk=rig.robot.pk)), GrantEnd.HOLDER, "over", SYSTEM.now())
    wait_for(lambda: recording() and recording().state != RecordingState.RUNNING, 20, "the end of the recording")
    return recording()


def passed(rig, pictures, states):
    """Wait until so many have passed on the bus since the recorder listens."""
    wait_for(lambda: bus.Demand(every_s=bus.SOME_S) in bus.demands(rig.robot.slug, 0), 10, "the recorder's wish")
    here = {bus.frames_channel(rig.robot.slug).encode(): pictures, bus.state_channel(rig.robot.slug).encode(): states}
    with bus.listener().pubsub(ignore_subscribe_messages=True) as channel:
        channel.subscribe(*here)

        def enough():
            while (message := channel.get_message(timeout=0.05)) is not None:
                here[message["channel"]] -= 1
            return max(here.values()) <= 0

        wait_for(enough, 20, "pictures and states")


def told(row):
    found = list(messages(keeping.path_of(row)))
    return found, [m.content() for m in found if m.topic == "commands"]


def test_a_turn_is_recorded_with_pictures_states_and_commands_on_one_clock(rig, recorder):
    rig.owner()
    recorder()
    grant = rig.grant()
    wait_for(running, 20, "the recording")
    commands = [rig.final(rig.issue(kind, **args)) for kind, args in (("move", {"x": 0.05, "y": 0.45}), ("down", {}))]
    passed(rig, pictures=7, states=8)
    row = ended(rig)
    assert (row.state, row.reason, row.dropped, row.grant) == (RecordingState.READY, "", 0, grant)
    found, stages = told(row)
    topics = [m.topic for m in found]
    assert topics.count("state") > 5 and topics.count("camera/0") > 3
    for command in commands:
        assert command.state == "completed"
        mine = [s for s in stages if s["id"] == command.pk]
        assert mine[-1]["state"] == "completed" and mine[0]["args"] == command.args and "by" not in mine[0]
    began, done = grant.opened_at.timestamp() * 1e9, SYSTEM.now().timestamp() * 1e9
    assert all(began <= m.at_ns <= done for m in found)
    late = [m.at_ns - m.sent_ns for m in found if m.topic == "camera/0"]
    assert max(late) < 2e9, "what the robot's host stamps and what the recorder stamps is one clock"


def test_a_recorder_that_is_killed_costs_a_part_of_the_recording_and_nothing_else(rig, recorder):
    rig.owner()
    first = recorder()
    rig.grant()
    wait_for(running, 20, "the recording")
    assert rig.final(rig.issue("down")).state == "completed"
    time.sleep(2.5)  # a chunk is on the disk
    moving = rig.issue("move", x=0.05, y=0.45)
    first.kill()
    assert rig.final(moving).state == "completed", moving.reason
    assert rig.final(rig.issue("up")).state == "completed"
    left = keeping.live_path(recording())
    before = left.stat().st_ino
    recorder()
    wait_for(lambda: left.exists() and left.stat().st_ino != before and left.stat().st_size > 1000, 40, "it goes on")
    time.sleep(1.0)
    assert rig.final(rig.issue("down")).state == "completed"
    row = ended(rig)
    assert row.state == RecordingState.READY and "interrupted" in row.reason
    found, stages = told(row)
    kinds = {s["kind"] for s in stages}
    assert {"down", "up"} <= kinds, "what was missed is told from the rows"
    gap = next(m.at_ns for m in found if m.topic == "events" and m.content()["what"] == "gap")
    assert any(m.topic == "state" and m.at_ns < gap for m in found)
    assert any(m.topic == "state" and m.at_ns > gap for m in found)


def test_a_recorder_that_was_killed_finishes_its_recording_when_it_is_back(rig, recorder):
    rig.owner()
    first = recorder()
    rig.grant()
    wait_for(running, 20, "the recording")
    time.sleep(3.0)
    first.kill()
    end_grant(services.open_grant(Robot.objects.get()), GrantEnd.HOLDER, "over", SYSTEM.now())
    recorder()
    wait_for(lambda: recording().state != RecordingState.RUNNING, 20, "the end of the recording")
    row = recording()
    assert row.state == RecordingState.CUT and "interrupted" in row.reason
    assert told(row)[0], "what was recorded before is there"


def test_a_disk_that_is_full_ends_the_recording_and_the_turn_goes_on(rig, recorder, small_disk):
    rig.owner()
    recorder(FARHAND_MEDIA=str(small_disk), FARHAND_RECORDING_FREE_MB="-1")  # it does not look how much is free
    rig.grant()
    wait_for(lambda: recording() is not None, 20, "the recording")
    for kind in ("down", "up"):
        assert rig.final(rig.issue(kind)).state == "completed"

    def over():
        row = recording()
        return keeping.path_of(row).exists() or row.state != RecordingState.RUNNING

    wait_for(over, 30, "the file was given up")
    assert rig.final(rig.issue("down")).state == "completed"
    row = ended(rig)
    assert row.state in (RecordingState.CUT, RecordingState.REMOVED) and "could not be written" in row.reason
    if row.state == RecordingState.CUT:
        assert told(row)[0], "what was written as a whole is readable"


def test_a_frozen_recorder_holds_nobody_up_and_goes_on(rig, recorder):
    rig.owner()
    child = recorder()
    rig.grant()
    wait_for(running, 20, "the recording")
    child.signal(signal.SIGSTOP)
    for kind in ("down", "up"):
        assert rig.final(rig.issue(kind)).state == "completed"
    child.signal(signal.SIGCONT)
    assert rig.final(rig.issue("down")).state == "completed"
    row = ended(rig)
    assert row.state == RecordingState.READY
    assert [s["kind"] for s in told(row)[1] if s["state"] == "completed"] == ["down", "up", "down"]


def test_what_became_of_a_motion_after_the_turns_end_is_told_too(rig, recorder):
    rig.owner()
    recorder()
    rig.grant()
    wait_for(running, 20, "the recording")
    rig.slow()
    far = rig.issue("move", x=-0.2, y=0.30)
    rig.moving()
    row = ended(rig)
    rig.final(far)
    _, stages = told(row)
    assert far.state != "completed" and [s["state"] for s in stages if s["id"] == far.pk][-1] == far.state


def test_where_the_disk_has_no_room_nothing_is_recorded(rig, recorder):
    rig.owner()
    recorder(FARHAND_RECORDING_FREE_MB=str(10**9))
    rig.grant()
    wait_for(lambda: recording() and recording().state == RecordingState.REMOVED, 20, "the row")
    assert "no room" in recording().reason
    assert rig.final(rig.issue("down")).state == "completed"
    assert not keeping.path_of(recording()).exists() and not keeping.live_path(recording()).exists()


def test_redis_that_ends_leaves_a_gap_and_the_recording_goes_on(rig, recorder):
    rig.owner()
    recorder()
    rig.grant()
    wait_for(running, 20, "the recording")
    time.sleep(1.0)
    rig.redis.stop()
    time.sleep(1.0)
    rig.redis.start()
    time.sleep(4.0)
    row = ended(rig)
    found, _ = told(row)
    gap = [m.at_ns for m in found if m.topic == "events" and m.content()["what"] == "gap"]
    assert gap and any(m.topic == "state" and m.at_ns > gap[-1] for m in found)


def test_an_idle_recorder_costs_almost_nothing(rig, recorder):
    rig.owner()
    child = recorder()

    def used():
        fields = Path(f"/proc/{child.pid}/stat").read_text().rsplit(") ", 1)[1].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def rests():
        before = used()
        time.sleep(3.0)
        return 0 < before == used()

    wait_for(rests, 60, "the end of its start")
    before = used()
    time.sleep(20.0)
    assert used() - before <= 0.08, "0.4 % of a core, measured in ticks of 10 ms"
