"""The movie of the day as the supervisor's processes send and serve it: chosen, killed, replaced, withdrawn."""

import asyncio
import json
import os
import signal
from pathlib import Path
from urllib.error import HTTPError
from urllib.request import urlopen

import pytest

from portal.broadcast.edge import GONE_NS
from portal.broadcast.timetable import SECOND
from portal.run.processes import broadcast_processes
from portal.run.supervisor import Supervisor
from robots.models import Movie, Recording
from robots.models.recordings import OfTheDay
from robots.recordings import keeping
from tests.faults.test_supervisor import nothing, run, until
from tests.rig import child_env, free_port
from tests.services.conftest import media
from tests.services.test_broadcast_network import group as group
from tests.services.test_job_movies import ran
from tests.services.test_movie_of_the_day import filmed
from tests.unit.test_broadcast_served import film

pytestmark = [
    pytest.mark.timed, pytest.mark.django_db(transaction=True), pytest.mark.usefixtures("media"),
    pytest.mark.parametrize("which", ["srv1"], indirect=True),
]  # fmt: skip
assert media  # the fixture
IDLE_S, IDLE_CORE = 6.0, 0.03  # how long it is looked at without a movie, and what share of a core it may take


class Station:
    """Origin and an edge under a supervisor, and what they say."""

    def __init__(self, lines):
        self._lines, self.port = lines, free_port()
        self.supervisor = Supervisor([], nothing, lambda name, text: lines.append(f"{name} | {text}"))

    def begin(self, settings, group):
        settings.BROADCAST_GROUP = f"{group[0]}:{group[1]}"
        settings.BROADCAST_PORT, settings.BROADCAST_EDGES = free_port(), [self.port]
        self.supervisor._fixed = broadcast_processes("127.0.0.1")

    def pid(self, name):
        return self.supervisor.children[name].pid

    async def status(self):
        """Return what the edge says of itself; nothing while it does not answer."""

        def asked():
            with urlopen(f"http://127.0.0.1:{self.port}/status.json", timeout=5) as answer:
                return json.load(answer)

        try:
            return await asyncio.to_thread(asked)
        except OSError:
            return {"movie": None, "whole": False, "packets": 0}

    async def until(self, true, seconds, what):
        for _ in range(int(seconds / 0.2)):
            status = await self.status()
            if true(status):
                return status
            await asyncio.sleep(0.2)
        raise AssertionError(f"{what}: not within {seconds} s: {status} {self._lines[-20:]}")

    async def shows(self, other=None):
        """Return the movie that the edge has as a whole, another than this one."""
        return (await self.until(lambda one: one["whole"] and one["movie"] != other, 60, "a movie"))["movie"]

    def index(self):
        try:
            with urlopen(f"http://127.0.0.1:{self.port}/index.m3u8", timeout=5) as answer:
                return answer.status, answer.read().decode()
        except HTTPError as error:
            return error.code, ""


def cpu_s(pid):
    return sum(map(int, Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[11:13])) / os.sysconf(
        "SC_CLK_TCK"
    )


def a_movie(robot, people, tmp_path, seconds):
    """Return a movie that is ready since yesterday, of so many seconds."""
    movie = filmed(ran(robot, people)[1])
    film(tmp_path / "day.mp4", seconds).replace(keeping.movie_path(movie))
    return movie


def test_the_movie_of_the_day_is_sent_by_itself(robot, people, settings, group, tmp_path, monkeypatch):
    for name, value in child_env(
        FARHAND_MEDIA=str(settings.MEDIA_ROOT), FARHAND_BROADCAST_GROUP=f"{group[0]}:{group[1]}"
    ).items():
        monkeypatch.setenv(name, value)
    lines = []
    station = Station(lines)
    station.begin(settings, group)
    monkeypatch.setenv("FARHAND_BROADCAST_PORT", str(settings.BROADCAST_PORT))

    async def story():
        await until(lambda: any("the movie: http" in line for line in lines), 60)
        await station.until(lambda one: "lost" in one, 60, "the edge answers")
        await asyncio.sleep(2)
        pids = station.pid("broadcast"), station.pid(f"edge {station.port}")
        before = [cpu_s(pid) for pid in pids]
        await asyncio.sleep(IDLE_S)
        shares = [(cpu_s(pid) - b) / IDLE_S for pid, b in zip(pids, before, strict=True)]
        print(f"idle: shares of a core {shares}")
        assert max(shares) < IDLE_CORE
        assert station.index()[0] == 503

        first = await asyncio.to_thread(a_movie, robot, people, tmp_path, 3)
        shown = await station.shows()
        await asyncio.sleep(8)
        status, playlist = await asyncio.to_thread(station.index)
        assert status == 200 and shown in playlist and first.recording.robot.name in playlist

        os.kill(pids[0], signal.SIGKILL)
        await until(lambda: station.pid("broadcast") not in (0, pids[0]), 30)
        packets = (await station.status())["packets"]
        heard = await station.until(lambda one: one["packets"] > packets + 100, 60, "it is sent again")
        assert heard["movie"] == shown

        second = await asyncio.to_thread(a_movie, robot, people, tmp_path, 4)
        again = station.pid("broadcast"), station.pid(f"edge {station.port}")
        other = await station.shows(shown)
        assert again == (station.pid("broadcast"), station.pid(f"edge {station.port}")), "without a restart"

        hides = Recording.objects.filter(pk=second.recording_id)
        await asyncio.to_thread(hides.update, of_the_day=OfTheDay.NEVER)
        gone = await station.until(lambda one: one["movie"] is None, GONE_NS / SECOND + 30, "it is forgotten")
        assert gone["movie"] is None and (await asyncio.to_thread(station.index))[0] == 503
        assert await station.shows(other) == shown, "then the one before is the newest"

    run(station.supervisor, story)
    assert Movie.objects.count() == 2
    assert any("withdrawn" in line for line in lines)
