"""Recordings and pictures while the time of day is set, or the date is wrong: nothing is lost or removed too early."""

import os
from datetime import UTC, datetime, timedelta

import pytest

from queueing.steps import carry
from robots import services
from robots.kit.recording.timeline import read_index
from robots.models import Frame, Movie, Recording, RecordingState, Records, Robot
from robots.recordings import keeping
from robots.states import GrantEnd, GrantKind
from robots.wall_clock import SETTLED_S, WallClock
from tests.services.clock_steps import HOUR, YEAR, each_step
from tests.waiting import CEILING_S
from workers.housekeeping.clean import old_frames
from workers.process import tasks
from workers.recorder.recorder import Recorder

pytestmark = pytest.mark.django_db


@pytest.fixture
def kept(robot, clock, settings, tmp_path):
    """A recording, a picture and a movie of yesterday."""
    settings.MEDIA_ROOT = tmp_path / "media"
    settings.RECORDING = settings.RECORDING | {"MOVIE_KEEP_DAYS": 9}
    at = clock.now() - timedelta(days=1)
    grant = services.start_grant(robot, GrantKind.TURN, at, None, at)
    services.end_grant(grant, "finished", "test", at)
    recording = keeping.begin(grant, "here", at)
    path = keeping.path_of(recording)
    path.parent.mkdir(parents=True)
    path.write_bytes(b"recorded")
    keeping.finish(recording, RecordingState.READY, "", at)
    Frame.objects.create(robot=robot, taken_at=at, file="frames/x.jpg")
    Movie.objects.create(robot=robot, recording=recording, kind="mp4", asked_at=at, state="failed")
    services.note_usage(robot.pk, services.slot_of(at), sent_bytes=1)

    def there():
        shown = Recording.objects.exclude(state=RecordingState.REMOVED).count()
        return shown, Frame.objects.count(), Movie.objects.count(), path.exists()

    return there


ALL, NOTHING = (1, 1, 1, True), (0, 0, 0, False)


def cleans(there, clock, looks, monkeypatch, hours):
    """Tick and clean for some hours; return what is there then."""
    monkeypatch.setattr(tasks, "wall_clock", lambda: looks)
    for _ in range(round(hours)):
        clock.go(HOUR)
        looks.follow(carry)
        tasks.clean()
    return there()


@pytest.mark.service
def test_a_wrong_date_that_is_corrected_within_a_day_loses_nothing(kept, clock, trusted, monkeypatch):
    clock.step(74 * YEAR)
    assert cleans(kept, clock, trusted, monkeypatch, 23) == ALL
    clock.step(-74 * YEAR)
    assert cleans(kept, clock, trusted, monkeypatch, 20) == ALL
    clock.go(3 * YEAR)
    assert cleans(kept, clock, trusted, monkeypatch, 48) == NOTHING, "what is old goes as ever"


@pytest.mark.service
@pytest.mark.parametrize("by", [74 * YEAR, -56 * YEAR])
def test_a_first_start_with_a_wrong_date_loses_nothing(kept, clock, tmp_path, monkeypatch, by):
    clock.step(by)
    looks = WallClock(tmp_path / "none-yet", clock)
    assert cleans(kept, clock, looks, monkeypatch, 23) == ALL
    clock.step(-by)
    assert cleans(kept, clock, looks, monkeypatch, 20) == ALL


@pytest.mark.service
def test_what_was_stored_while_it_was_1970_is_kept(kept, clock, trusted, monkeypatch):
    old = datetime(1970, 1, 2, tzinfo=UTC)
    for rows, name in ((Frame, "taken_at"), (Recording, "began_at"), (Movie, "asked_at")):
        rows.objects.update(**{name: old})
    assert cleans(kept, clock, trusted, monkeypatch, 20) == ALL
    assert old_frames(clock.now()) == 0


def test_no_file_is_taken_for_old_because_the_time_of_day_was_set_ahead(kept, clock, trusted, settings, monkeypatch):
    """As one that is being written at this moment."""
    new = keeping.live_path(Recording.objects.get())
    new.parent.mkdir(parents=True, exist_ok=True)
    new.write_bytes(b"part")
    os.utime(new, (clock.now().timestamp(),) * 2)
    clock.step(5 * HOUR)
    monkeypatch.setattr(tasks, "wall_clock", lambda: trusted)
    for _ in range(2):
        trusted.follow(carry)
        tasks.clean()
        assert new.exists()
        clock.go(SETTLED_S)


def test_a_picture_is_taken_out_of_a_recording_during_which_the_time_of_day_was_set_back(kept, robot, clock):
    recording = Recording.objects.get()
    Recording.objects.update(ended_at=recording.began_at - timedelta(hours=1))
    found = keeping._around(robot, recording.began_at - timedelta(minutes=70))
    assert [one.pk for one in found] == [recording.pk]


class Recorded:
    """A turn that is recorded to a file, with an event each second; what a page is told of it."""

    def __init__(self, robot, clock):
        self.clock, self.expected_ms = clock, [0]
        self.recorder = Recorder(clock, "here")
        Robot.objects.update(records=Records.WORK)
        self.grant = services.start_grant(robot, GrantKind.TURN, clock.now(), None, clock.now() + timedelta(minutes=5))
        self.recorder._look()
        self.recorder._tell_all("notice", "began")

    def goes_on(self, seconds=3):
        for _ in range(seconds):
            self.clock.go(1)
            self.recorder._tell_all("notice", "goes on")
            self.expected_ms.append(self.expected_ms[-1] + 1000)

    def starts_again(self, seconds=4):
        """Let the recorder stop, and the next one go on with the file."""
        self.recorder._end_all()
        self.clock.go(seconds)
        self.recorder = Recorder(self.clock, "here")
        self.recorder._look()

    def ended(self):
        services.end_grant(self.grant, GrantEnd.FINISHED, "over", self.clock.now())
        self.recorder._look()
        (one,) = self.recorder._ending
        assert one.taping.written.wait(CEILING_S)
        self.recorder._look()
        row = Recording.objects.get()
        return row, read_index(keeping.path_of(row))


@pytest.fixture
def recorded(robot, owned, clock, trusted, settings, tmp_path, monkeypatch):
    settings.MEDIA_ROOT = tmp_path / "media"
    settings.RECORDING = settings.RECORDING | {"FREE_MB": 0}
    monkeypatch.setattr(Recorder, "_measure_offset", lambda self: None)  # the clock of this test is the database's
    return Recorded(robot, clock)


@each_step
def test_a_recording_goes_on_evenly(recorded, clock, trusted, by):
    began_ms = clock.now().timestamp() * 1000
    recorded.goes_on()
    clock.step(by)
    recorded.goes_on(1)
    trusted.follow(carry)
    recorded.goes_on()
    row, index = recorded.ended()
    assert (row.state, row.reason) == ("ready", "")
    assert [event["after_ms"] for event in index.events] == recorded.expected_ms
    assert index.began_ms == pytest.approx(began_ms, abs=2)
    assert len(index.needs) == 2, "slices of 5 s that a page asks for"


@each_step
def test_a_recording_goes_on_when_its_recorder_is_started_again_after_the_time_of_day_was_set(recorded, clock, by):
    recorded.goes_on()
    clock.step(by)
    recorded.starts_again()
    recorded.goes_on()
    row, index = recorded.ended()
    assert row.state == "ready"
    after_ms = [event["after_ms"] for event in index.events]
    assert after_ms == sorted(after_ms)
    assert len(after_ms) == len(recorded.expected_ms) + 1, "with a word of the gap"
    assert after_ms[-1] <= recorded.expected_ms[-1] + 5000
    assert len(index.needs) <= 3


def test_a_recording_whose_recorder_is_started_again_keeps_its_time(recorded, clock):
    recorded.goes_on()
    recorded.starts_again()
    recorded.goes_on()
    assert recorded.ended()[1].events[-1]["after_ms"] == 10_000
