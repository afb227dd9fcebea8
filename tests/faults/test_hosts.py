"""More than one web process and more than one host: what fails comes back by itself, and viewers go on."""

import itertools
import json
import sys
import threading
import time
from contextlib import ExitStack
from datetime import timedelta

import pytest
from django.conf import settings
from django.db import connection

from queueing import services as queue
from queueing.models import Ticket
from robots.grants import end_grant
from robots.kit.recording.reading import messages
from robots.models import Recording, RecordingState, Records, Robot
from robots.recordings import keeping
from robots.states import GrantEnd
from tests.conftest import at_length, wait_for
from tests.crowd import MANY, Crowd
from tests.faults.hosts import Host
from tests.faults.proxy import Proxy
from tests.faults.test_viewers import Viewer
from tests.rig import Child, Simulator, Web, free_port

# ruff: noqa: TID251 - its tests are timed
pytestmark = pytest.mark.timed

CROWD, LOOK_S = 300, 1.5  # how many watch two processes; how long one looks whether all get pictures
SOON_S = 40


class Reading:
    """Viewers who read in threads of their own; `new` are those who got a picture after a moment."""

    def __init__(self, webs, each):
        self.viewers = [Viewer(web, buffer=1 << 16) for web in webs for _ in range(each)]
        self.last = [0.0] * len(self.viewers)
        self.gone = set()
        for n in range(len(self.viewers)):
            threading.Thread(target=self._read, args=(n,), daemon=True).start()

    def _read(self, n):
        viewer = self.viewers[n]
        viewer.line.settimeout(120)
        try:
            while viewer.read():
                if viewer.pictures():
                    self.last[n] = time.monotonic()
                viewer.received.clear()
        except OSError:
            pass
        self.gone.add(n)

    def new(self, since):
        return sum(last > since for last in self.last)

    def close(self):
        for viewer in self.viewers:
            viewer.close()


class Both:
    """Two web processes with half of a crowd each; who is cut off comes back after a random pause, first to the other."""

    def __init__(self):
        with ExitStack() as stack:
            self.webs = [Web(**MANY) for _ in range(2)]
            for web in self.webs:
                stack.callback(web.kill)
            also = str(self.webs[1].port)
            self._crowd = stack.enter_context(Crowd(self.webs[0].url, CROWD, LOOK_S, "--again", "--also", also))
            self._stack = stack.pop_all()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._stack.close()

    def all_see(self, seconds, what):
        """Wait until everybody is there and gets pictures; return how many sockets were cut off so far."""
        begun = time.monotonic()
        while True:
            seen = self._crowd.watch()
            if (seen["here"], seen["without"]) == (CROWD, 0):
                return seen["lost"]
            assert time.monotonic() - begun < seconds, f"{what}: not within {seconds} s: {seen}"


def ticked(rig):
    """Wait until housekeeping has ended an offer that nobody took."""
    now = rig.now()
    ticket = Ticket.objects.create(
        queue=queue.queue_of(rig.robot), user=rig.people["eve"], state="offered", start_tag=0, joined_at=now,
        last_seen=now, offer_until=now - timedelta(seconds=1),
    )  # fmt: skip
    wait_for(lambda: Ticket.objects.get(pk=ticket.pk).state != "offered", SOON_S, "the tick of the queues")
    ticket.delete()


@pytest.mark.parametrize("aways_s", [(2.0,), at_length((0.0, 4.0))], ids=["once", "twice"])
def test_redis_restarted_under_load_ends_no_process_and_everybody_sees_pictures_again(
    rig, redis_server, house, aways_s
):
    Robot.objects.update(records=Records.WORK)
    owner, housekeeper = rig.owner(), house.housekeeping()
    recorder = Child("recorder", [sys.executable, "-m", "workers.recorder"], FARHAND_RECORDING_FREE_MB="1")
    backs = []
    try:
        with Both() as both:
            grant = rig.grant(seconds=600)
            wait_for(lambda: Recording.objects.filter(grant=grant).exists(), 20, "the recording")
            both.all_see(SOON_S, "at first")
            for away_s in aways_s:
                redis_server.stop()
                time.sleep(away_s)
                redis_server.start()
                backs.append(rig.now())
                assert not both.all_see(SOON_S, "after Redis came back"), "no socket was cut off"
                ticked(rig)
                wait_for(lambda: rig.final(rig.issue("noop")).state == "completed", SOON_S, "commands go on")
            assert owner.alive() and housekeeper.alive() and recorder.alive()
            assert all(web.alive() for web in both.webs)
        end_grant(grant, GrantEnd.HOLDER, "over", rig.now())
        row = Recording.objects.get(grant=grant)
        wait_for(lambda: row.refresh_from_db() or row.state != RecordingState.RUNNING, SOON_S, "its end")
        taken = [m.at_ns / 1e9 for m in messages(keeping.path_of(row)) if m.topic == "camera/0"]
        edges = [*(at.timestamp() for at in backs), rig.now().timestamp()]
        for began, ended in itertools.pairwise(edges):
            assert any(began < at < ended for at in taken), "it records on after each restart"
    finally:
        recorder.kill()


def test_a_web_process_that_is_killed_takes_only_its_own_viewers_and_they_come_back_elsewhere(rig):
    rig.owner()
    with Both() as both:
        both.all_see(SOON_S, "at first")
        both.webs[0].kill()
        assert both.all_see(SOON_S, "after the kill") == CROWD // 2, "nobody else was cut off"
        assert both.webs[1].alive()


def test_a_worker_s_host_that_is_cut_off_stops_its_robot_and_serves_again_when_it_is_back(rig):
    if connection.vendor != "postgresql":
        pytest.skip("a worker on another host needs PostgreSQL")
    host, db = Host(), connection.settings_dict
    stores = {
        "REDIS_URL": settings.REDIS_URL.removeprefix("unix://"),
        "DATABASE_URL": f"{db['HOST']}/.s.PGSQL.{db['PORT'] or 5432}",
    }
    doors = {name: Proxy((host.here, free_port()), to) for name, to in stores.items()}
    env = {
        "REDIS_URL": f"redis://{host.here}:{doors['REDIS_URL'].at[1]}/0",
        "DATABASE_URL": f"postgres://{db['USER']}:@{host.here}:{doors['DATABASE_URL'].at[1]}/{db['NAME']}",
    }
    web = crowd = None
    try:
        rig.own()
        rig.sim.stop()
        rig.sim = Simulator(rig.sim.folder, before=host.before)
        owner = rig.start_worker(before=host.before, **env)
        rig.wait_ready()
        web = Web()
        crowd = Reading([web], 5)
        wait_for(lambda: crowd.new(0.0) == 5, 20, "pictures from the other host")
        rig.grant(seconds=600)
        rig.slow()
        command = rig.issue("move", x=0.2, y=0.33)
        rig.moving()
        host.cut()
        wait_for(lambda: not rig.sim.status()["moving"], 6, "rest: an owner without a lease stops its robot")
        wait_for(lambda: status(web) == "Offline", 20, "the page says so")
        assert rig.lease().expires_at <= rig.now(), "only after the lease has lapsed"
        host.join()
        wait_for(
            lambda: Robot.objects.get().cycle in ("ready", "operating") and status(web) != "Offline", 60, "it is back"
        )
        joined = time.monotonic()
        wait_for(lambda: crowd.new(joined) == 5, 30, "pictures again")
        assert owner.alive(), "the same process"
        assert rig.final(command).state in ("cancelled", "unknown", "failed")
    finally:
        if crowd is not None:
            crowd.close()
        if web is not None:
            web.kill()
        for child in rig.workers:
            child.kill()
        for door in doors.values():
            door.close()
        host.close()


def status(web):
    """Return the robot's state as a newcomer reads it."""
    one = Viewer(web)
    said = next(json.loads(s) for s in one.texts() if "snapshot" in s)
    one.close()
    return said["robot"]["label"]
