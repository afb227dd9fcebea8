"""Movies of recordings and time-lapses: who may request them, how many, what is in them, and when they are removed."""

import json
import os
import subprocess
import sys
from datetime import timedelta
from pathlib import Path

import av
import cv2
import numpy as np
import pytest
from django.conf import settings
from django.db import OperationalError

from operatorlog import services as log
from operatorlog.models import Entry, Visibility
from queueing.models import Turn
from robots.kit.clock import SYSTEM, ms_of
from robots.kit.contract.errors import BadRequest
from robots.kit.packets import picture_packet
from robots.kit.recording.packets import picture_of
from robots.models import Frame, Grant, Movie, Recording, RecordingState
from robots.recordings import cleaning, keeping, movies
from robots.states import GrantKind
from tests.conftest import wait_for
from tests.services.tapes import jpeg, let_make, tape_of
from workers.recorder.movies import LEAST, MovieMaker

pytestmark = [pytest.mark.django_db, pytest.mark.usefixtures("media")]
LONG_AGO = timedelta(days=2)


def made(grant, pictures=((0, 0), (500, 100), (1000, 200)), age=timedelta()):
    """Return a recording with pictures: (ms after its beginning, grey)."""
    recording = keeping.begin(grant, "here", SYSTEM.now() - age)
    with tape_of(recording) as (tape, began):
        for n, (ms, grey) in enumerate(pictures):
            data = jpeg(grey) if grey is not None else b"no picture"
            tape.put("camera/0", (began + ms) * 10**6, picture_of(picture_packet(n, began + ms, 0, (), data)))
    keeping.finish(recording, RecordingState.READY, "", recording.began_at + timedelta(seconds=5))
    return recording


@pytest.fixture
def recording(roles):
    return made(Turn.objects.get().grant)


def shown(path):
    """Return when each picture of a movie is shown (s), and how bright its middle is."""
    with av.open(str(path)) as movie:
        assert movie.streams.video[0].codec_context.name in ("h264", "vp9")
        return [(float(f.time), int(f.to_ndarray(format="gray")[80, 90])) for f in movie.decode(video=0)]


@pytest.mark.parametrize("kind", ["mp4", "webm"])
def test_a_movie_shows_each_picture_when_it_was_taken(recording, client, kind):
    address = f"{recording.get_absolute_url()}movie.{kind}"
    assert client.get(address).status_code == 404
    client.post(f"{recording.get_absolute_url()}movie/", {"kind": kind})
    movie = let_make(Movie.objects.get())
    assert movie.state == Movie.State.READY, movie.reason
    found = shown(keeping.movie_path(movie))
    assert [round(at, 2) for at, _ in found] == [0.0, 0.5, 1.0]
    assert all(abs(grey - wanted) < 12 for (_, grey), wanted in zip(found, (0, 100, 200), strict=True))
    answer = client.get(address)
    assert answer.status_code == 200 and answer["Content-Type"] == f"video/{kind}"
    assert client.get(address, headers={"Range": "bytes=0-99"}).status_code == 206
    page = client.get(recording.get_absolute_url()).content.decode()
    assert address in page


def grey_of(cell):
    return int(cell[cell.shape[0] // 2, cell.shape[1] // 2])


@pytest.mark.parametrize("torn", [False, True])
def test_a_movie_shows_all_cameras_side_by_side(roles, torn):
    """Three cells and an empty one; one of a camera of another shape is fitted in, and all tell the same moment."""
    recording = made(Turn.objects.get().grant, ())
    wide = cv2.imencode(".jpg", np.full((100, 400), 220, np.uint8))[1].tobytes()
    pictures = [(0, 0, jpeg(60)), (5, 2, wide), (0, 1, jpeg(140)), (1000, 0, jpeg(100)), (2000, 2, b"broken")]
    with tape_of(recording) as (tape, began):
        for n, (ms, camera, data) in enumerate(pictures):
            packet = picture_packet(n, began + ms, camera, (), data)
            tape.put(f"camera/{camera}", (began + ms) * 10**6 + n, picture_of(packet))
    if torn:
        os.truncate(keeping.path_of(recording), tape.whole - 20)  # no index
    movie = let_make(movies.ask(recording, "mp4", SYSTEM.now()))
    assert movie.state == Movie.State.READY, movie.reason
    with av.open(str(keeping.movie_path(movie))) as file:
        seen = [(round(float(f.time), 1), f.to_ndarray(format="gray")) for f in file.decode(video=0)]
    assert [at for at, _ in seen] == [0.0, 1.0]
    last = seen[-1][1]
    assert last.shape == (2 * 164, 2 * 192)
    cells = last[:164, :192], last[:164, 192:], last[164:, :192], last[164:, 192:]
    assert np.allclose([grey_of(cell) for cell in cells], (100, 140, 220, 0), atol=20)
    assert grey_of(cells[2][:40]) < 20, "the wide picture is whole, so there is nothing above it"


def test_pictures_that_are_broken_are_left_out_and_a_pause_is_shortened(roles):
    movie = movies.ask(
        made(Turn.objects.get().grant, ((0, 10), (400, None), (800, 50), (60_000, 90))), "mp4", SYSTEM.now()
    )
    assert let_make(movie).state == Movie.State.READY
    assert [round(at, 1) for at, _ in shown(keeping.movie_path(movie))] == [0.0, 0.8, 5.8]


def test_a_recording_without_pictures_makes_no_movie(roles, client):
    recording = made(Turn.objects.get().grant, ())
    movie = let_make(movies.ask(recording, "webm", SYSTEM.now()))
    assert movie.state == Movie.State.FAILED and movie.reason == "It has no pictures."
    assert movie.reason in client.get(recording.get_absolute_url()).content.decode()


def test_a_time_lapse_has_a_picture_in_ten_seconds_and_leaves_out_what_is_hidden(roles, client):
    turn = Turn.objects.get()
    recording = made(turn.grant, [(ms, 120) for ms in range(0, 60_000, 1000)], LONG_AGO)
    day = recording.began_at.date()
    asked = {"day": str(day), "kind": "mp4"}
    assert client.post("/robots/mercury/time-lapse/", asked).status_code == 302
    movie = let_make(Movie.objects.get())
    assert len(shown(keeping.movie_path(movie))) == 6
    address = f"/robots/mercury/time-lapse/{day}.mp4"
    assert client.get(address).status_code == 200
    assert address in client.get("/robots/mercury/recordings/").content.decode()
    Entry.objects.create(
        turn=turn, author=turn.user, robot=turn.robot, text="x", written_at=SYSTEM.now(), visibility=Visibility.HIDDEN
    )
    assert client.get(address).status_code == 404
    file = keeping.movie_path(movie)
    client.post("/robots/mercury/time-lapse/", asked)
    assert not Movie.objects.exists(), "nothing else is kept of that day"
    assert not file.exists()


def still(robot, grant, name, grey):
    """Store a picture of the day of `LONG_AGO`."""
    at = SYSTEM.now() - LONG_AGO
    frame = Frame.objects.create(robot=robot, grant=grant, taken_at=at, file=f"frames/{robot.slug}/x/{name}.jpg")
    path = Path(settings.MEDIA_ROOT) / frame.file
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(jpeg(grey))
    return frame


def hide(turn, roles):
    at = SYSTEM.now()
    entry = Entry.objects.create(turn=turn, author=turn.user, robot=turn.robot, text="x", written_at=at)
    log.moderate(entry, roles["log_moderator"], Visibility.HIDDEN, "rude", at)
    return entry


def test_a_time_lapse_leaves_out_the_pictures_of_a_hidden_entry(roles, client):
    turn = Turn.objects.get()
    theirs, other = still(turn.robot, turn.grant, "theirs", 40), still(turn.robot, None, "other", 200)
    hide(turn, roles)
    asked = {"day": str(other.taken_at.date()), "kind": "mp4"}
    client.post("/robots/mercury/time-lapse/", asked)
    movie = Movie.objects.get()
    assert movies.plan_of(movie)["files"] == [(str(Path(settings.MEDIA_ROOT) / other.file), ms_of(other.taken_at))]
    other.delete()
    client.post("/robots/mercury/time-lapse/", asked)
    assert not Movie.objects.exists(), "only what is hidden is kept of that day"
    assert theirs.pk


@pytest.mark.service
@pytest.mark.parametrize("state", [Movie.State.WAITING, Movie.State.MAKING, Movie.State.READY])
def test_hiding_an_entry_forgets_the_time_lapses_with_its_pictures(
    roles, client, state, tmp_path, django_capture_on_commit_callbacks
):
    turn = Turn.objects.get()
    day = still(turn.robot, turn.grant, "theirs", 40).taken_at.date()
    client.post("/robots/mercury/time-lapse/", {"day": str(day), "kind": "mp4"})
    movie, part = Movie.objects.get(), tmp_path / "made.part"
    file = keeping.movie_path(movie)
    file.parent.mkdir()
    file.write_bytes(b"movie")
    Movie.objects.update(state=state)
    address = f"/robots/mercury/time-lapse/{day}.mp4"
    assert client.get(address).status_code == (200 if state == Movie.State.READY else 404)
    with django_capture_on_commit_callbacks(execute=True):
        entry = hide(turn, roles)
        assert client.get(address).status_code == 404, "even before it is forgotten"
    assert not Movie.objects.exists() and not file.exists()
    part.write_bytes(b"movie")
    movies.finish(movie, part, "", SYSTEM.now())
    assert not file.exists(), "nor does it come back from the maker"
    log.moderate(entry, roles["log_moderator"], Visibility.PUBLISHED, "", SYSTEM.now())
    client.post("/robots/mercury/time-lapse/", {"day": str(day), "kind": "mp4"})
    assert len(movies.plan_of(Movie.objects.get())["files"]) == 1


@pytest.mark.service
def test_hiding_an_entry_leaves_time_lapses_of_other_days_and_robots(roles, client, django_capture_on_commit_callbacks):
    turn = Turn.objects.get()
    day = still(turn.robot, turn.grant, "theirs", 40).taken_at.date()
    other = Movie.objects.create(
        robot=turn.robot, day=day - timedelta(days=1), kind="mp4", asked_at=SYSTEM.now(), sources=["other"]
    )
    with django_capture_on_commit_callbacks(execute=True):
        hide(turn, roles)
    assert Movie.objects.get() == other


def test_a_time_lapse_goes_with_a_recording_of_its_day_and_is_made_again_of_the_others(roles, client):
    turn = Turn.objects.get()
    first = made(turn.grant, [(ms, 120) for ms in range(0, 30_000, 1000)], LONG_AGO)
    began = first.began_at
    job = Grant.objects.create(robot=turn.robot, kind=GrantKind.JOB, opened_at=began, ended_at=began, epoch=0)
    other = made(job, [(ms, 60) for ms in range(0, 30_000, 1000)], LONG_AGO)
    both = movies.ask_day(turn.robot, first.began_at.date(), "mp4", [first, other], [], SYSTEM.now())
    let_make(both)
    file = keeping.movie_path(both)
    keeping.remove(other, "to make room")
    assert not Movie.objects.exists() and not file.exists(), "it shows what is removed"
    again = movies.ask_day(turn.robot, first.began_at.date(), "mp4", [first], [], SYSTEM.now())
    assert let_make(again).state == Movie.State.READY


def test_a_movie_whose_file_no_backup_has_can_be_asked_for_again(recording):
    movie = let_make(movies.ask(recording, "mp4", SYSTEM.now()))
    keeping.movie_path(movie).unlink()
    keeping.settle_restored(SYSTEM.now())
    assert let_make(movies.ask(recording, "mp4", SYSTEM.now())).state == Movie.State.READY


@pytest.mark.service
def test_a_movie_that_could_not_be_noted_at_once_is_noted_at_the_next_look(recording, monkeypatch):
    movie, noted = movies.ask(recording, "mp4", SYSTEM.now()), []

    def finish(*args, real=movies.finish):
        noted.append(args)
        if len(noted) < 3:
            if len(noted) == 2:  # the file was moved, then the database went
                args[1].replace(keeping.movie_path(movie))
            raise OperationalError("the database is away")
        real(*args)

    monkeypatch.setattr(movies, "finish", finish)
    maker = MovieMaker(SYSTEM, nice=0)
    maker.look()
    wait_for(lambda: maker._process.poll() is not None, 60, "the program")
    for _ in range(2):
        with pytest.raises(OperationalError):
            maker.look()
    maker.look()
    movie.refresh_from_db()
    assert (movie.state, len(noted)) == (Movie.State.READY, 3)
    assert shown(keeping.movie_path(movie))


@pytest.mark.service
def test_bad_wishes_are_refused_with_a_sentence(recording, client):
    now = SYSTEM.now()
    with pytest.raises(BadRequest, match="MP4 or WebM"):
        movies.ask(recording, "exe", now)
    with pytest.raises(BadRequest, match="over"):
        movies.ask_day(recording.robot, now.date(), "mp4", [recording], [], now)
    with pytest.raises(BadRequest, match="Nothing is kept"):
        movies.ask_day(recording.robot, now.date() - timedelta(days=9), "mp4", [], [], now)
    for data in ({"kind": "../x"}, {}):
        answer = client.post(f"{recording.get_absolute_url()}movie/", data, follow=True)
        assert "MP4 or WebM" in answer.content.decode()
    answer = client.post("/robots/mercury/time-lapse/", {"day": "yesterday", "kind": "mp4"}, follow=True)
    assert "Choose a day" in answer.content.decode()
    assert not Movie.objects.exists()


@pytest.mark.service
def test_one_movie_of_a_kind_and_no_more_than_can_be_made(recording, client, settings):
    now = SYSTEM.now()
    assert movies.ask(recording, "mp4", now) == movies.ask(recording, "mp4", now)
    settings.RATE_LIMITS = settings.RATE_LIMITS | {"movie": "1/h/ip"}
    client.post(f"{recording.get_absolute_url()}movie/", {"kind": "mp4"})
    answer = client.post(f"{recording.get_absolute_url()}movie/", {"kind": "webm"}, follow=True)
    assert "too many movies" in answer.content.decode() and Movie.objects.count() == 1
    for n in range(movies.WAITING):
        Movie.objects.create(robot=recording.robot, day=now.date() - timedelta(days=9 + n), kind="mp4", asked_at=now)
    with pytest.raises(BadRequest, match="Too many"):
        movies.ask(recording, "webm", now)


@pytest.mark.service
def test_what_a_maker_began_and_did_not_finish_is_made_by_the_next(recording):
    movie = movies.ask(recording, "mp4", SYSTEM.now())
    first = MovieMaker(SYSTEM, nice=0)
    first.look()
    first.close()
    movie.refresh_from_db()
    assert movie.state == Movie.State.MAKING
    assert let_make(movie).state == Movie.State.READY
    assert [p.name for p in keeping.movie_path(movie).parent.iterdir()] == [f"{movie.pk}.mp4"]


@pytest.mark.service
def test_movies_go_with_their_recording_and_after_some_days(recording):
    movie = let_make(movies.ask(recording, "mp4", SYSTEM.now()))
    path = keeping.movie_path(movie)
    assert path.exists()
    assert cleaning.clean(SYSTEM.now() + timedelta(days=2)) == 0
    assert cleaning.clean(SYSTEM.now() + timedelta(days=4)) == 1
    assert not path.exists()
    movie = let_make(movies.ask(recording, "mp4", SYSTEM.now()))
    keeping.remove(Recording.objects.get(), "Staff removed it.")
    assert not keeping.movie_path(movie).exists() and not Movie.objects.exists()


def test_a_movie_is_made_when_nobody_else_needs_the_machine(recording):
    movies.ask(recording, "mp4", SYSTEM.now())
    maker = MovieMaker(SYSTEM)
    maker.look()
    try:
        wait_for(lambda: os.getpriority(os.PRIO_PROCESS, maker._process.pid) == LEAST, 60, "the lowest priority")
    finally:
        maker.close()


def test_a_program_that_is_given_rubbish_makes_nothing(tmp_path):
    (tmp_path / "x.mcap").write_bytes(b"rubbish")
    plan = json.dumps({"hz": 5, "files": [[str(tmp_path / "x.mcap"), 0]]})
    argv = [sys.executable, "-m", "robots.kit.recording.movie", "mp4", str(tmp_path / "x.part"), "0"]
    done = subprocess.run(argv, input=plan, capture_output=True, text=True, check=False)
    assert done.stdout.split()[-1:] == ["0"], done.stdout


@pytest.mark.service
def test_a_movie_that_two_recorders_made_stays(recording, tmp_path):
    """One begins while the other, on another host with the same pictures, is at it."""
    asked = movies.ask(recording, "mp4", SYSTEM.now())
    first = movies.claim(SYSTEM.now())
    movies.again()
    second = movies.claim(SYSTEM.now())
    keeping.movie_path(asked).parent.mkdir(parents=True, exist_ok=True)
    for n, one in enumerate((first, second)):
        made = tmp_path / f"{n}.part"
        made.write_bytes(b"movie")
        movies.finish(one, made, "", SYSTEM.now())
    asked.refresh_from_db()
    assert (asked.state, keeping.movie_path(asked).read_bytes()) == (Movie.State.READY, b"movie")
