"""Promises 22 to 24: Redis, PostgreSQL and the disk may fail, and work goes on by itself."""

import json
import os
import subprocess
import time
import urllib.error
import urllib.request

import pytest
from django.conf import settings
from django.db import connection, connections

from robots import services
from robots.models import Command, Robot
from robots.states import COMMAND_FINAL
from tests.conftest import at_length, wait_for
from tests.faults.test_promises_data import works
from tests.faults.test_promises_stop import drain, held_after, socket_of
from tests.rig import Web

# ruff: noqa: TID251 - its tests are timed
pytestmark = pytest.mark.timed

PAGES = ("/", "/robots/mercury/", "/status/", "/log/", "/story/", "/classic/mercury/")


def fetch(web, path):
    """Return (status, text) of a page."""
    try:
        with urllib.request.urlopen(web.url + path, timeout=15) as answer:
            return answer.status, answer.read().decode()
    except urllib.error.HTTPError as error:
        return error.code, error.read().decode()


@pytest.fixture
def web():
    made = []

    def start(**env):
        made.append(Web(**env))
        return made[-1]

    yield start
    for one in made:
        one.kill()


def back_after(rig, seconds=15.0):
    """Return after how many seconds a command is carried out again by itself."""
    begun = time.monotonic()
    works(rig, seconds)
    return time.monotonic() - begun


@pytest.mark.asvs("16.5.2")
def test_promise_22_a_redis_outage_is_survived(rig, web, proof):
    """Killed and started again: pages answer, the banner is shown, work goes on within 15 s."""
    times = proof.count("restarts of Redis", 2, 50)
    rig.owner()
    rig.grant(seconds=3000)
    site = web()
    slowest = 0.0
    with socket_of(site, rig.people["ada"]) as operator:
        heard = drain(operator)
        wait_for(lambda: any(m["t"] == "snapshot" and m["link"] for m in heard), 10, "the link")
        for i in range(times):
            heard.clear()
            rig.redis.stop()
            wait_for(lambda: any(m["t"] == "snapshot" and not m["link"] for m in heard), 10, "the banner")
            for path in PAGES if i < 3 else PAGES[:2]:
                assert fetch(site, path)[0] == 200, path
            operator.send(json.dumps({"t": "command", "kind": "noop", "args": {}, "seq": 10_000 + i}))
            if i % 3 == 2:
                time.sleep(2.0)
            rig.redis.start()
            slowest = max(slowest, back_after(rig))
            wait_for(lambda: any(m["t"] == "snapshot" and m["link"] for m in heard), 10, "the banner goes")
    assert rig.workers[0].alive(), "the worker needed no restart"
    assert not Command.objects.exclude(state__in=COMMAND_FINAL).exists()
    proof.holds(f"{times} restarts: pages 200, banner shown and gone; working again {slowest:.1f} s after, at most")


@pytest.mark.asvs("16.5.2")
@pytest.mark.parametrize("how", ["cut", at_length("reset"), at_length("stall")])
def test_promise_23_a_database_outage_is_survived(rig, web, proof, how):
    """The robot is held, commands are refused with a reason, everything goes on by itself."""
    if connection.vendor != "postgresql":
        pytest.skip("SQLite has no line that could break")
    times = proof.count(f"outages, {how}", 1, 6, 20)
    proxy, env = rig.database_proxy()
    site = web(**env)
    worst_rest = worst_back = 0.0
    supervisor = Supervised(rig, env)
    rig.wait_ready()
    rig.grant(seconds=3000)
    Robot.objects.update(settings={"speed": 0.02})
    rig.swept()
    try:
        with socket_of(site, rig.people["ada"]) as operator:
            heard = drain(operator)
            wait_for(lambda: any(m["t"] == "snapshot" for m in heard), 20, "the page")  # while one opens, it is slower
            for i in range(times):
                command = rig.issue("move", x=0.2 if i % 2 else -0.2, y=0.3)
                rig.moving()
                heard.clear()
                at = time.monotonic()
                proxy.set(how)
                operator.send(json.dumps({"t": "ping", "n": i}))  # to note presence keeps no command waiting
                operator.send(json.dumps({"t": "command", "kind": "up", "args": {}, "seq": 10_000 + i}))
                worst_rest = max(worst_rest, held_after(rig, at))
                wait_for(lambda: any(m["t"] == "answer" and m["code"] == "store_down" for m in heard), 20, "the reason")
                if i == 0:
                    status, text = fetch(site, "/")
                    assert status == 503
                    assert "database does not answer" in text
                proxy.set("pass")
                assert rig.final(command, 30).state in ("unknown", "cancelled", "completed")
                worst_back = max(worst_back, back_after(rig, 20))
                assert fetch(site, "/")[0] == 200
    finally:
        supervisor.stop()
    # a lease of 3 s that cannot be renewed ends, and so does the motion
    assert worst_rest <= 4.0, worst_rest
    assert worst_back <= 15.0, worst_back
    proof.holds(
        f"{how}: {times} outages: at rest after {worst_rest:.1f} s, working again {worst_back:.1f} s after its end"
    )


class Supervised:
    """A worker that is started again when it ends, as the supervisor does."""

    def __init__(self, rig, env):
        import threading

        self._rig, self._env, self._on = rig, env, True
        rig.start_worker(**env)
        self._thread = threading.Thread(target=self._keep, daemon=True)
        self._thread.start()

    def _keep(self):
        while self._on:
            if not self._rig.workers[-1].alive():
                self._rig.start_worker(**self._env)
            time.sleep(0.3)
        connections.close_all()

    def stop(self):
        self._on = False
        self._thread.join()


def test_promise_23_sqlite_under_two_writers(rig, proof):
    """A second writer holds the file for a second at a time: work waits and goes on."""
    if connection.vendor != "sqlite":
        pytest.skip("this is about SQLite's one writer")
    import sqlite3

    times = proof.count("times the file was held for a second", 3, 30)
    rig.owner()
    rig.grant(seconds=3000)
    other = sqlite3.connect(connection.settings_dict["NAME"], timeout=20, isolation_level=None)
    try:
        for i in range(times):
            command = rig.issue("move", x=0.1 if i % 2 else -0.1, y=0.4)
            other.execute("BEGIN IMMEDIATE")
            time.sleep(1.0)
            other.execute("COMMIT")
            command = rig.final(command, 20)
            assert command.state == "completed", command.reason
    finally:
        other.close()
    assert rig.workers[0].alive()
    proof.holds(f"{times} motions under a second writer: all completed, the owner kept its lease")


def test_promise_24_a_full_disk(rig, web, proof):
    """Pictures on a small tmpfs that is full: it is said, nothing told is lost, stop works."""
    proof.count("full disks", 1, 1)
    folder = settings.VAR / "small"
    folder.mkdir(exist_ok=True)
    if subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=4m", "none", str(folder)], capture_output=True, check=False
    ).returncode:
        pytest.skip("mounting a tmpfs needs root")
    env = {"FARHAND_MEDIA": str(folder / "media")}
    try:
        (folder / "media").mkdir()
        rig.start_worker(**env)
        rig.wait_ready()
        rig.grant(seconds=3000)
        site = web(**env)
        with (folder / "ballast").open("wb") as out, pytest.raises(OSError, match="No space"):
            while True:
                out.write(os.urandom(65536))
                out.flush()
        command = rig.final(rig.issue("move", x=0.1, y=0.4))
        assert command.state == "completed"
        assert "disk may be full" in command.result["note"]
        status, text = fetch(site, "/log/")
        assert status == 200
        assert "disk is full" in text
        with socket_of(site, rig.people["ada"]) as operator:
            heard = drain(operator)
            wait_for(
                lambda: any(m["t"] == "snapshot" and "disk is full" in m["store"] for m in heard), 10, "the banner"
            )
            rig.issue("move", x=-0.2, y=0.3)
            rig.moving()
            at = time.monotonic()
            operator.send(json.dumps({"t": "stop"}))
            seconds = held_after(rig, at)
            wait_for(lambda: any(m["t"] == "answer" and m["to"] == "stop" for m in heard), 5, "an answer")
            assert Robot.objects.get().stop_latched
            (folder / "ballast").unlink()
            services.release_stop(rig.robot, rig.people["ada"], checked=True)
            wait_for(lambda: not (settings.VAR / "run/mercury.stopped").exists(), 5, "the release")
            time.sleep(0.5)
            command = rig.final(rig.issue("move", x=0.0, y=0.4))
            assert command.result.get("still"), "pictures are kept again by themselves"
    finally:
        for child in rig.workers:
            child.kill()
        subprocess.run(["umount", "-l", str(folder)], check=False)
    assert seconds < 0.5
    proof.holds(
        f"said in the command, the banner and the pages; stop held after {seconds * 1000:.0f} ms; well again by itself"
    )
