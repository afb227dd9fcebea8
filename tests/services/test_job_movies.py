"""Movies that are made automatically after a job: which, when, after failures, and how the job's page shows them."""

import json
import subprocess
from base64 import b64encode
from datetime import timedelta

import pytest
from django.test import Client

from queueing.models import Job, JobRun, JobState
from queueing.services import Asker, ask
from robots.grants import end_grant, start_grant
from robots.kit.clock import SYSTEM
from robots.models import Command, Finding, Frame, Movie, Recording, RecordingState, Robot
from robots.recordings import cleaning, keeping, movies
from robots.states import CommandState, GrantEnd, GrantKind
from tests.conftest import FakeClock
from tests.services.tapes import jpeg, let_make, tape_of
from workers.recorder.movies import MovieMaker

pytestmark = [
    pytest.mark.django_db, pytest.mark.usefixtures("media"), pytest.mark.parametrize("which", ["srv1"], indirect=True)
]  # fmt: skip
GREY = jpeg(90)
TEXT = "go South\nphotograph\nread\nsay nobody else reads this\n"
PATH = [(1.0 + 0.25 * n, 1.0 + 0.065 * n, 0.25) for n in range(21)]  # from home to the node South


def ran(robot, people, picture=GREY, kind="mission", args=None):
    """Return a job of ada's that is done, with what it found, and its recording: pictures and states for ten seconds."""
    now = SYSTEM.now() - timedelta(seconds=20)
    job = ask(robot, Asker(user=people["ada"]), kind, args or {"text": TEXT}, now)
    grant = start_grant(robot, GrantKind.JOB, now)
    JobRun.objects.create(job=job, grant=grant)
    command = Command.objects.create(
        robot=robot, grant=grant, kind=kind, args=job.args, client_seq=1, epoch=1, created_at=now, deadline=now,
        sent_at=now + timedelta(seconds=1), state=CommandState.COMPLETED, ended_at=now + timedelta(seconds=11),
    )  # fmt: skip
    recording = taped(keeping.begin(grant, "here", now), picture)
    frame = Frame.objects.create(robot=robot, grant=grant, command=command, taken_at=now, file="frames/x.jpg")
    at = now + timedelta(seconds=11)
    Finding.objects.create(command=command, number=1, at=at, text="photograph", pose=[*PATH[-1]], frame=frame)
    values, pose = {"light": 31.0, "temperature": 20.5}, [*PATH[-1]]
    Finding.objects.create(command=command, number=2, at=at, text="readings", values=values, pose=pose)
    end_grant(grant, GrantEnd.FINISHED, "", now + timedelta(seconds=12))
    Job.objects.filter(pk=job.pk).update(state=JobState.DONE, ended_at=now + timedelta(seconds=12))
    keeping.finish(recording, RecordingState.READY, "", now + timedelta(seconds=12))
    job.refresh_from_db()
    return job, recording


def taped(recording, picture):
    with tape_of(recording) as (tape, began):
        for n, (x, y, heading) in enumerate(PATH):
            at = (began + 1000 + 500 * n) * 10**6
            tape.put("state", at, {"values": {"x": x, "y": y, "heading": heading, "light": 30.0}})
            told = {"number": n, "still": 0, "joints": [], "timestamp": {"sec": 1, "nsec": 0}}
            tape.put("camera/0", at, told | {"data": b64encode(picture).decode()})
    return recording


def page(job):
    return Client().get(job.get_absolute_url()).content.decode()


def test_a_movie_of_a_mission_comes_by_itself_and_its_page_offers_it(robot, people):
    job, recording = ran(robot, people)
    said = page(job)
    assert "A movie of it will be made." in said and "data-arrives" in said and 'http-equiv="refresh"' in said
    maker = MovieMaker(SYSTEM, nice=0)
    maker.look()
    movie = Movie.objects.get()
    assert (movie.recording, movie.kind, movie.unasked) == (recording, Movie.Kind.MP4, True)
    assert "A movie of it is being made." in page(job)
    let_make(movie, maker)
    assert movie.state == Movie.State.READY, movie.reason
    said = page(job)
    assert f'href="{recording.get_absolute_url()}movie.mp4"' in said and "data-arrives" not in said
    assert Client().get(f"{recording.get_absolute_url()}movie.mp4").status_code == 200
    maker._looked = -1e9
    maker.look()
    assert Movie.objects.count() == 1, "once"


def test_the_page_shows_the_path_driven_over_the_path_planned(robot, people):
    job, recording = ran(robot, people)
    movies.ask_due(SYSTEM.now())
    let_make(Movie.objects.get())
    recording.refresh_from_db()
    assert recording.track["driven"][0][0] == [1.0, 1.0] and len(json.dumps(recording.track)) < 20_000
    said = page(job)
    assert said.count("<polyline") == 2 and "It drove 5.2 m, from (1.0, 1.0) to (6.0, 2.3)." in said
    assert "it ended 0.0 m from where the plan ends" in said and "Pictures: 1 at (6.0, 2.3)" in said
    assert 'role="img" aria-labelledby="path-1"' in said and 'id="path-1"' in said
    assert "nobody else reads this" not in said, "the text of a mission is its author's"
    keeping.remove(recording, "Staff removed it.")
    recording.refresh_from_db()
    assert recording.track == {} and "<polyline" not in page(job), "the path goes with the recording"


def test_without_a_recording_the_page_joins_the_places_that_were_noted(robot, people):
    job, _ = ran(robot, people)
    command = Command.objects.get()
    for number, pose in ((3, [2.0, 1.0, 0.0]), (4, [2.0, 3.0, 1.0]), (5, []), (6, [1.0])):
        Finding.objects.create(command=command, number=number, at=SYSTEM.now(), text="x", pose=pose)
    Recording.objects.all().delete()
    said = page(job)
    assert said.count("<polyline") == 1 and "In straight lines between the places at which it noted something" in said
    Finding.objects.all().delete()
    assert "<svg" not in page(job).partition('id="job"')[2]


@pytest.mark.parametrize(("kind", "args", "due"), [("mission", None, 1), ("go", {"x": 6.0, "y": 2.3}, 1)])
def test_programs_and_what_a_robot_declares_are_filmed(robot, people, kind, args, due):
    ran(robot, people, kind=kind, args=args)
    assert movies.ask_due(SYSTEM.now()) == due


def of_staff(recording):
    recording.grant.kind = GrantKind.STAFF
    recording.grant.save()


def of_another_kind(recording):
    Command.objects.update(kind="patrol")


def of_a_robot_that_is_gone(recording):
    Robot.objects.update(driver="nobody")


def of_a_job_that_goes_on(recording):
    recording.grant.ended_at = None
    recording.grant.save()


def of_two_days_ago(recording):
    Recording.objects.update(ended_at=SYSTEM.now() - timedelta(days=2))


@pytest.mark.parametrize(
    "changed", [of_staff, of_another_kind, of_a_robot_that_is_gone, of_a_job_that_goes_on, of_two_days_ago]
)
def test_no_other_recording_is_filmed_by_itself(robot, people, changed):
    _, recording = ran(robot, people)
    changed(recording)
    assert movies.ask_due(SYSTEM.now()) == 0 and not Movie.objects.exists()


def test_what_is_not_filmed_is_looked_at_once(robot, people, django_assert_num_queries):
    _, recording = ran(robot, people)
    of_another_kind(recording)
    movies.ask_due(SYSTEM.now())
    with django_assert_num_queries(2):
        assert movies.ask_due(SYSTEM.now()) == 0


def test_who_asks_is_served_before_movies_that_come_by_themselves(robot, people):
    _, recording = ran(robot, people)
    movies.ask_due(SYSTEM.now())
    own = Movie.objects.get()
    asked = movies.ask(recording, "webm", SYSTEM.now())
    assert (own.ahead, asked.ahead) == (1, 0)
    assert movies.claim(SYSTEM.now()) == asked
    hastened = movies.ask(recording, "mp4", SYSTEM.now())
    own.refresh_from_db()
    assert hastened == own and not own.unasked


def test_a_movie_that_was_removed_to_make_room_does_not_come_again_by_itself(robot, people, settings):
    ran(robot, people)
    movies.ask_due(SYSTEM.now())
    let_make(Movie.objects.get())
    settings.RECORDING = settings.RECORDING | {"MOVIES_MB": 0}
    assert cleaning.clean(SYSTEM.now()) == 1
    assert movies.ask_due(SYSTEM.now()) == 0 and not Movie.objects.exists()


def test_no_more_wait_at_once_than_the_recorder_makes_soon(robot, people):
    ran(robot, people)
    for _ in range(movies.UNASKED + 2):
        grant = start_grant(robot, GrantKind.JOB, SYSTEM.now())
        Command.objects.create(
            robot=robot, grant=grant, kind="mission", client_seq=1, epoch=1, created_at=SYSTEM.now(),
            deadline=SYSTEM.now(),
        )  # fmt: skip
        recording = taped(keeping.begin(grant, "here", SYSTEM.now()), b"")
        end_grant(grant, GrantEnd.FINISHED, "", SYSTEM.now())
        keeping.finish(recording, RecordingState.READY, "", SYSTEM.now())
    assert movies.ask_due(SYSTEM.now()) == movies.UNASKED
    assert movies.ask_due(SYSTEM.now()) == 0
    Movie.objects.update(state=Movie.State.READY)
    assert movies.ask_due(SYSTEM.now()) == 3


def by_hand():
    """Return a clock that is moved by hand, of the same day."""
    clock = FakeClock()
    clock.step((SYSTEM.now() - clock.now()).total_seconds())
    return clock


def all_tries(movie, clock):
    """Let a maker try as often as it does, with the pauses between; return what the row said each time."""
    maker, said = MovieMaker(clock, nice=0), []
    while movie.open:
        let_make(movie, maker)
        said.append((movie.state, movie.tries))
        maker.look()
        assert maker._process is None, "not at once again"
        clock.go(movies.AGAIN.total_seconds() + 1)
        assert len(said) <= movies.TRIES
    return said


@pytest.mark.parametrize("fault", ["pictures", "file", "disk"])
def test_a_movie_that_cannot_be_made_costs_no_picture_and_the_page_says_so(robot, people, fault, settings, tmp_path):
    job, recording = ran(robot, people, b"no picture at all" if fault == "pictures" else GREY)
    path = keeping.path_of(recording)
    if fault == "file":
        path.write_bytes(path.read_bytes()[:40] + bytes(200))
    kept, rows = path.read_bytes(), (Frame.objects.count(), Finding.objects.count())
    clock = by_hand()
    if fault == "disk":
        folder = keeping.movie_path(Movie(pk=1)).parent
        folder.mkdir()
        if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=8k", "none", str(folder)], check=False).returncode:
            pytest.skip("mounting a tmpfs needs root")
    try:
        movies.ask_due(clock.now())
        movie = Movie.objects.get()
        maker = MovieMaker(clock, nice=0)
        let_make(movie, maker)
        assert (movie.state, movie.tries) == (Movie.State.WAITING, 1)
        assert "The movie could not be made yet" in page(job) and "data-arrives" in page(job)
        clock.go(movies.AGAIN.total_seconds() + 1)
        assert [tries for _, tries in all_tries(movie, clock)] == [2, 3]
    finally:
        if fault == "disk":
            subprocess.run(["umount", "--lazy", str(folder)], check=False)
    assert movie.state == Movie.State.FAILED and movie.reason
    said = page(job)
    assert f"The movie could not be made, tried 3 times: {movie.reason}" in said and "Try again" in said
    assert "Pictures and recording are not touched" in said and "data-arrives" not in said
    assert path.read_bytes() == kept and rows == (Frame.objects.count(), Finding.objects.count())
    assert movies.ask_due(clock.now()) == 0
    assert movies.ask(recording, "mp4", clock.now()).state == Movie.State.WAITING, "somebody may ask once more"


def test_where_the_disk_has_no_room_it_is_tried_again_later(robot, people, settings):
    ran(robot, people)
    settings.RECORDING = settings.RECORDING | {"FREE_MB": 10**9}
    clock = by_hand()
    MovieMaker(clock, nice=0).look()
    movie = Movie.objects.get()
    assert (movie.state, movie.tries, movie.reason) == ("waiting", 1, "The server's disk has no room for it.")
    settings.RECORDING = settings.RECORDING | {"FREE_MB": 0}
    clock.go(movies.AGAIN.total_seconds() + 1)
    assert let_make(movie, MovieMaker(clock, nice=0)).state == Movie.State.READY
