"""Pictures taken down: no recording shows them any more, whatever happens to its file."""

from datetime import timedelta

import pytest

from queueing.models import Turn
from robots.grants import end_grant, start_grant
from robots.kit.clock import SYSTEM
from robots.kit.packets import picture_packet
from robots.kit.recording.packets import picture_of
from robots.kit.recording.reading import messages
from robots.models import Movie, RecordingState
from robots.recordings import cleaning, keeping
from robots.states import GrantEnd, GrantKind
from tests.services.tapes import tape_of

pytestmark = [pytest.mark.service, pytest.mark.django_db, pytest.mark.usefixtures("media")]
SECOND = timedelta(seconds=1)


def begun(robot, began, stills):
    """Return a recording that runs, with one picture a second."""
    end_grant(robot.grants.get(ended_at=None), GrantEnd.FINISHED, "", SYSTEM.now())
    recording = keeping.begin(start_grant(robot, GrantKind.TURN, SYSTEM.now()), "here", began)
    with tape_of(recording) as (tape, ms):
        for n, still in enumerate(stills):
            at = ms + 1000 * n
            tape.put("camera/0", at * 10**6, picture_of(picture_packet(n, at, still, (), b"a picture")))
    return recording


def made(robot, began, stills):
    recording = begun(robot, began, stills)
    keeping.finish(recording, RecordingState.READY, "", began + len(stills) * SECOND)
    return recording


def stills(recording):
    return [m.content()["still"] for m in messages(keeping.path_of(recording))]


@pytest.fixture
def of_turns(roles, robot):
    assert Turn.objects.exists()
    return robot


def test_a_later_recording_that_begins_with_the_same_pose_loses_it_too(of_turns):
    at = SYSTEM.now() - timedelta(hours=1)
    first = made(of_turns, at - 5 * SECOND, [0] * 3 + [7] * 3)
    later = [made(of_turns, at + n * timedelta(minutes=5), s) for n, s in ((1, [7, 7, 8]), (2, [8, 9]))]
    assert keeping.take_out_pictures(of_turns, at, 7) == 2
    assert [stills(one) for one in (first, *later)] == [[0, 0, 0], [8], [8, 9]]


@pytest.mark.parametrize("late", [-7, 3])
def test_pictures_at_the_edges_of_a_recording_are_taken_out(of_turns, late):
    began = SYSTEM.now() - timedelta(hours=1)
    recording = made(of_turns, began, [0] * 4)
    at = began + 4 * SECOND + 3 * SECOND if late > 0 else began - 3 * SECOND
    lapse = Movie.objects.create(
        robot=of_turns, day=(began - timedelta(days=3)).date(), sources=[recording.pk], kind="mp4", asked_at=began
    )
    assert keeping.take_out_pictures(of_turns, at, 0) == 1
    assert not Movie.objects.filter(pk=lapse.pk).exists(), "a time-lapse of it goes, whatever its day"


def test_a_file_that_cannot_be_written_again_is_never_shown(of_turns):
    recording = begun(of_turns, SYSTEM.now(), [0] * 4)
    keeping.take_out_pictures(of_turns, recording.began_at, 0)
    keeping.path_of(recording).unlink()
    keeping.path_of(recording).symlink_to(keeping.path_of(recording).parent)  # a reader gets an error
    keeping.finish(recording, RecordingState.READY, "", SYSTEM.now())
    assert recording.state == RecordingState.REMOVED and "taken down" in recording.reason
    assert not keeping.path_of(recording).exists()


def test_one_bad_file_does_not_stop_cleaning(of_turns):
    bad, good = (begun(of_turns, SYSTEM.now() - n * SECOND, [0] * 4) for n in (9, 3))
    end_grant(good.grant, GrantEnd.FINISHED, "", SYSTEM.now())
    keeping.path_of(bad).unlink()
    keeping.path_of(bad).mkdir()
    (keeping.path_of(bad) / "x").touch()
    keeping.path_of(good).rename(keeping.live_path(good))
    keeping.live_path(bad).write_bytes(keeping.live_path(good).read_bytes())
    cleaning.clean(SYSTEM.now() + timedelta(hours=2))
    good.refresh_from_db()
    assert good.state == RecordingState.CUT


def test_what_was_left_while_it_was_copied_is_taken_whole(of_turns):
    recording = begun(of_turns, SYSTEM.now(), [1, 2, 3])
    path = keeping.path_of(recording)
    path.rename(path.with_suffix(keeping.OLD))
    keeping.live_path(recording).write_bytes(b"cut off")
    keeping.salvage(recording)
    assert stills(recording) == [1, 2, 3]
    assert [one.name for one in path.parent.iterdir()] == [path.name]


def test_movies_have_a_limit_together_and_files_of_none_are_removed(of_turns, settings):
    settings.RECORDING = settings.RECORDING | {"MOVIES_MB": 2}
    now = SYSTEM.now()
    for n in range(3):
        movie = Movie.objects.create(
            robot=of_turns, day=(now - n * timedelta(days=1)).date(), kind="mp4", asked_at=now, size=900_000,
            state=Movie.State.READY, ready_at=now - n * SECOND,
        )  # fmt: skip
        keeping.movie_path(movie).parent.mkdir(parents=True, exist_ok=True)
        keeping.movie_path(movie).touch()
    keeping.movie_path(movie).with_name("99.part").touch()
    Movie.objects.filter(pk=Movie.objects.latest("day").pk).update(size=1)
    making = Movie.objects.create(
        robot=of_turns, day=(now - timedelta(days=9)).date(), kind="mp4", asked_at=now, state=Movie.State.MAKING
    )
    part = keeping.movie_path(movie).with_name(f"{making.pk}-0a1b.part")
    part.touch()
    assert cleaning.clean(now) == 1, "99.part"
    Movie.objects.exclude(pk=making.pk).update(size=900_000)
    assert cleaning.clean(now) == 1 and not Movie.objects.filter(pk=movie.pk).exists()
    assert part.exists(), "it is being made"
    making.delete()
    assert cleaning.clean(now) == 1 and not part.exists()
    assert len(list(keeping.movie_path(movie).parent.iterdir())) == 2
