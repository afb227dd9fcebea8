"""A movie of a mission of the hall rover: recorded by the real recorder, made by the real program, decoded again."""

from math import dist

import av
import numpy as np
import pytest

from robots import services
from robots.grants import end_grant
from robots.kit.clock import MachineClock
from robots.kit.recording import chart
from robots.kit.recording.film import TOP
from robots.models import Finding, Movie, Recording, RecordingState, Records, Robot
from robots.recordings import keeping, movies
from robots.services.commands import issue_under
from robots.states import Cycle, GrantEnd, GrantKind
from tests.conftest import wait_for
from tests.world.seeds import hunt
from workers.recorder.movies import MovieMaker
from workers.recorder.recorder import Recorder

pytestmark = pytest.mark.parametrize("which", ["srv1"], indirect=True)
MISSION = "read\nphotograph\ngo South\nphotograph\nturn 90\n"
MASK = [0, 0, 0, 320, 60]  # the upper quarter of its camera's pictures
PLACE = 6.0, 2.3  # of the node South


@pytest.fixture(autouse=True)
def media(settings, tmp_path):
    settings.MEDIA_ROOT = tmp_path / "media"
    settings.RECORDING = settings.RECORDING | {"FREE_MB": 0}


def recorded(portal):
    """Have a mission carried out as a job while it is recorded; return its recording."""
    Recording.objects.all().delete()
    Robot.objects.update(records=Records.WORK, settings={"privacy_masks": [MASK]})
    over = []
    portal.world.spawn(
        lambda: Recorder(portal.world, "here").run(lambda: bool(over)), "recorder", portal.world.process("recorder")
    )
    portal.ready()
    Robot.objects.filter(pk=portal.robot.pk).update(cycle=Cycle.OPERATING)
    now = portal.world.now()
    grant = services.start_grant(portal.robot, GrantKind.JOB, now)
    portal.until(lambda: Recording.objects.exists(), 10, "the recording")
    command = issue_under(grant, portal.people["ada"], "mission", {"text": MISSION}, 1, now).command
    assert portal.final(command, 90).state == "completed", command.reason
    end_grant(grant, GrantEnd.FINISHED, "", portal.world.now())
    portal.until(lambda: Recording.objects.exclude(state=RecordingState.RUNNING).exists(), 20, "its end")
    over.append(True)
    portal.world.sleep(1.0)
    return Recording.objects.get()


def boxes(data):
    """Return the kinds of the boxes of an MP4 in their order."""
    found, at = [], 0
    while at < len(data):
        found.append(data[at + 4 : at + 8].decode())
        at += int.from_bytes(data[at : at + 4], "big")
    return found


def like(picture, colour):
    """Return how many pixels have a colour, as exactly as a movie keeps it."""
    return int((np.abs(picture.astype(int) - colour).max(axis=2) < 40).sum())


def made(portal):
    recording = recorded(portal)
    assert movies.ask_due(portal.world.now()) + Movie.objects.count() >= 1
    movie, clock = Movie.objects.get(), MachineClock()
    maker = MovieMaker(clock, nice=0)

    def done():
        maker.look()
        movie.refresh_from_db()
        return not movie.open

    wait_for(done, 300, "the movie")
    assert (movie.state, movie.reason, movie.unasked) == (Movie.State.READY, "", True)
    data = keeping.movie_path(movie).read_bytes()
    assert boxes(data)[:3] == ["ftyp", "moov", "sidx"] and boxes(data).count("moof") >= 2
    with av.open(str(keeping.movie_path(movie))) as file:
        frames = [(float(f.time), f.to_ndarray(format="rgb24")) for f in file.decode(video=0)]
    lasted = (recording.ended_at - recording.began_at).total_seconds()
    times, first, last = [at for at, _ in frames], frames[0][1], frames[-1][1]
    assert times[0] == 0 and abs(times[-1] - lasted) < 3, "it lasts as long as the job"
    assert first.shape == (360, 640, 3)
    masked = [frame[TOP : TOP + 60, :352] for _, frame in frames]
    assert all(like(one, (0, 0, 0)) > 0.99 * 60 * 352 for one in masked), "nobody sees what is masked"
    assert like(last[TOP + 80 :, :352], (0, 0, 0)) < 0.5 * 184 * 352
    plot = last[TOP:, 352:]
    assert like(plot[:220], chart.DRIVEN) > 100 > like(first[TOP : TOP + 220, 352:], chart.DRIVEN)
    assert like(frames[len(frames) // 4][1][TOP : TOP + 220, 352:], chart.PLANNED) > 50, "before it is driven over"
    assert like(plot[:220], chart.TAKEN) > 60, "the numbers of its pictures"
    assert like(last[:TOP], (255, 255, 255)) > 100, "captions"
    recording.refresh_from_db()
    driven, planned = (recording.track[name] for name in ("driven", "planned"))
    assert dist(driven[-1][-1], PLACE) < 0.3 and dist(planned[-1][-1], PLACE) < 0.01
    assert Finding.objects.exclude(frame=None).count() == 2


def test_a_movie_of_a_mission_shows_the_path_driven_over_the_path_planned(worlds):
    hunt(worlds, 1, made)
