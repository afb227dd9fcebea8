"""More than one web process and more than one host: what fails comes back by itself, and viewers go on."""

import json
import threading
import time

import pytest
from django.conf import settings
from django.db import connection

from robots.models import Robot
from tests.conftest import wait_for
from tests.faults.hosts import Host
from tests.faults.proxy import Proxy
from tests.faults.test_viewers import Viewer
from tests.rig import Simulator, Web, free_port

CROWD, SOON_S = 10, 40


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


@pytest.mark.alone
def test_redis_restarted_under_load_ends_no_process_and_everybody_sees_pictures_again(rig, redis_server):
    owner = rig.owner()
    webs = [Web(), Web()]
    crowd = Reading(webs, CROWD)
    try:
        wait_for(lambda: crowd.new(0.0) == 2 * CROWD, 20, "pictures for all")
        for away_s in (0.0, 2.0):
            redis_server.stop()
            time.sleep(away_s)
            redis_server.start()
            back = time.monotonic()
            wait_for(lambda back=back: crowd.new(back) == 2 * CROWD, SOON_S, "pictures for all after Redis came back")
        assert not crowd.gone
        assert owner.alive()
        assert all(web.alive() for web in webs)
    finally:
        crowd.close()
        for web in webs:
            web.kill()


def test_a_web_process_that_is_killed_takes_only_its_own_viewers_and_they_come_back_elsewhere(rig):
    rig.owner()
    webs = [Web(), Web()]
    crowd = Reading(webs, CROWD)
    try:
        wait_for(lambda: crowd.new(0.0) == 2 * CROWD, 20, "pictures for all")
        webs[0].kill()
        killed = time.monotonic()
        wait_for(lambda: len(crowd.gone) == CROWD, 5, "the end of its sockets")
        again = Reading([webs[1]], CROWD)
        wait_for(lambda: crowd.new(killed) == CROWD and again.new(killed) == CROWD, 20, "pictures for all again")
        assert crowd.gone == set(range(CROWD))
        again.close()
    finally:
        crowd.close()
        for web in webs:
            web.kill()


@pytest.mark.tenth
@pytest.mark.alone  # beside it a browser would notice that the network changes
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
        rig.slow()
        rig.grant(seconds=600)
        command = rig.issue("move", x=0.2, y=0.33)
        rig.moving()
        host.cut()
        cut = time.monotonic()
        wait_for(lambda: not rig.sim.status()["moving"], 6, "rest: an owner without a lease stops its robot")
        wait_for(lambda: status(web) == "Offline", 20, "the page says so")
        assert time.monotonic() - cut > 2.0, "only after the lease has lapsed"
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
