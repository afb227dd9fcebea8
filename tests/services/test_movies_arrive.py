"""A movie shows its progress while it is made, appears on the page by itself, and is made once for all requests."""

import json
import subprocess
import sys
import threading
from datetime import timedelta

import numpy as np
import pytest
from django.db import connection

from queueing.models import Turn
from robots.kit.clock import SYSTEM, ms_of
from robots.models import Movie
from robots.recordings import keeping, movies
from tests.conftest import wait_for
from tests.services.test_movies import made
from workers.recorder.movies import COMMAND, MovieMaker

pytestmark = [pytest.mark.django_db, pytest.mark.usefixtures("media")]
# pictures of noise, which fill several chunks of a file soon: its program may wait long for the processor
NOISE = np.random.default_rng(1).integers(0, 255, (24, 164, 193), np.uint8)
LONG = [(500 * n, picture) for n, picture in enumerate(NOISE)]


@pytest.fixture
def recording(roles):
    return made(Turn.objects.get().grant, LONG)


def test_the_program_prints_each_percent_once_and_at_last_the_count(recording, tmp_path):
    plan = json.dumps({"hz": 5, "files": [(str(keeping.path_of(recording)), ms_of(recording.began_at))] * 5})
    argv = [sys.executable, *COMMAND[1:], "mp4", str(tmp_path / "x.part"), "0"]
    done = subprocess.run(argv, input=plan, capture_output=True, text=True, check=True)
    *percents, count = done.stdout.splitlines()
    assert int(count) >= 5 * len(LONG) - 5, "the first picture of a file may come with the last of another"
    told = [int(line.removesuffix(" %")) for line in percents]
    assert told == sorted(set(told)) and len(told) >= 5 and all(0 < percent < 100 for percent in told)


def test_how_far_a_movie_is_stands_in_its_row_and_on_the_page(recording, client):
    movie, seen, maker = movies.ask(recording, "mp4", SYSTEM.now()), [], MovieMaker(SYSTEM, nice=0)
    page = client.get(recording.get_absolute_url()).content.decode()
    assert "data-arrives" in page and "It is next" in page and "is being made" in page
    assert '<noscript><meta http-equiv="refresh"' in page, "who has no scripts is served too"

    def done():
        maker.look()
        movie.refresh_from_db()
        seen.append(movie.progress)
        return not movie.open

    wait_for(done, 300, "the movie")
    assert movie.state == Movie.State.READY, movie.reason
    assert seen == sorted(seen)
    Movie.objects.update(state=Movie.State.MAKING)
    movies.progress(movie, 37)
    page = client.get(recording.get_absolute_url()).content.decode()
    assert 'max="100" value="37"' in page and "37 %" in page
    Movie.objects.update(state=Movie.State.FAILED, reason="The server's disk has no room for it.")
    page = client.get(recording.get_absolute_url()).content.decode()
    assert "no room for it" in page and "Try again" in page
    assert "data-arrives" not in page and "http-equiv" not in page
    movies.progress(movie, 99)
    movie.refresh_from_db()
    assert movie.progress == 37, "of one that is made no more nothing is noted"


@pytest.mark.service
def test_what_its_program_said_last_is_noted_while_it_runs(recording):
    movie, maker = movies.ask(recording, "mp4", SYSTEM.now()), MovieMaker(SYSTEM, nice=0)
    maker.look()
    wait_for(lambda: maker._process.poll() is not None or "%" in maker._lines()[-1], 60, "the first percent")
    maker._said.seek(0)
    maker._said.truncate()
    maker._said.write("12 %\n61 %\n")
    maker._said.flush()
    maker._tell(movie)
    movie.refresh_from_db()
    assert movie.progress == 61
    maker.close()
    assert movies.again() is None
    movies.claim(SYSTEM.now())
    movie.refresh_from_db()
    assert movie.progress == 0, "another one begins anew"


@pytest.mark.service
def test_movies_that_wait_tell_how_many_are_before_them(recording, client):
    now = SYSTEM.now()
    for n, state in enumerate((Movie.State.MAKING, Movie.State.WAITING, Movie.State.READY)):
        day = now.date() - timedelta(days=9 + n)
        Movie.objects.create(robot=recording.robot, day=day, kind="mp4", asked_at=now, state=state)
    movie = movies.ask(recording, "mp4", now)
    assert movie.ahead == 2
    assert "2 before it" in client.get(recording.get_absolute_url()).content.decode()
    page = client.get("/robots/mercury/recordings/").content.decode()
    assert page.count("<progress") == 2 and "data-arrives" in page and "http-equiv" in page
    Movie.objects.filter(day__isnull=False).update(state=Movie.State.FAILED, reason="It has no pictures.")
    page = client.get("/robots/mercury/recordings/").content.decode()
    assert page.count("Try again") == 3 and "It has no pictures." in page and "http-equiv" not in page


@pytest.mark.service
@pytest.mark.skipif(connection.vendor != "postgresql", reason="one at a time writes to SQLite")
@pytest.mark.django_db(transaction=True)
@pytest.mark.parametrize("failed", [False, True])
def test_two_who_ask_at_once_have_one_movie_made(recording, failed):
    if failed:
        movies.ask(recording, "mp4", SYSTEM.now())
        Movie.objects.update(state=Movie.State.FAILED)
    together, found = threading.Barrier(4), []

    def ask():
        together.wait(60)
        found.append(movies.ask(recording, "mp4", SYSTEM.now()).pk)
        connection.close()

    people = [threading.Thread(target=ask) for _ in range(4)]
    for one in people:
        one.start()
    for one in people:
        one.join(60)
    assert len(found) == 4 and set(found) == {Movie.objects.get().pk}
    assert movies.claim(SYSTEM.now()) is not None and movies.claim(SYSTEM.now()) is None


@pytest.mark.service
def test_where_nobody_makes_movies_the_page_says_so(recording, client):
    movies.ask(recording, "mp4", SYSTEM.now() - timedelta(minutes=16))
    page = client.get(recording.get_absolute_url()).content.decode()
    assert "The server makes no movies now." in page and "It is next" not in page
