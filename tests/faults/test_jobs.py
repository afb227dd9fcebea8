"""A robot without a driver takes goals from two guests in turn, recharges in between, and roams."""

import json
import shutil
import socket

import pytest
from django.conf import settings
from django.test import Client

from portal.keep.seeding import add_robot
from portal.run.processes import robot_processes
from queueing import services as queue
from queueing.models import Account, Job, JobRun, Queue
from robots import bus
from robots.kit.clock import SYSTEM
from robots.models import Command, Frame, Grant, Robot
from robots.states import Cycle
from tests.conftest import wait_for
from tests.packaged import SHUTTLE, installed_from
from tests.rig import Child

pytestmark = pytest.mark.timed

GOALS = 4  # of each guest: 7 m in all, and a battery lasts for 5


class Guest:
    """A guest without an account, who asks for the next goal when the last one is reached."""

    def __init__(self, address, goals):
        self.client, self.address, self.goals, self.job = Client(REMOTE_ADDR=address), address, list(goals), None

    def go_on(self):
        if self.job is not None:
            self.job.refresh_from_db()
        if self.goals and (self.job is None or self.job.ended_at):
            said = self.client.post("/robots/shuttle/jobs/", {"kind": "go", "arg-x": self.goals.pop(0)})
            self.job = Job.objects.get(key=said["Location"].split("/")[2])
        return not self.goals and self.job.ended_at


def left_behind(robot):
    """Return a job that waits on a rail which is taken away meanwhile; nothing is begun, as while the robot charges."""
    Queue.objects.update(paused=True)
    said = Client(REMOTE_ADDR="192.0.2.9").post("/robots/shuttle/jobs/", {"kind": "go", "arg-x": 0.5, "arg-rail": 1})
    job = Job.objects.get(key=said["Location"].split("/")[2])
    with socket.socket(socket.AF_UNIX) as line:
        line.connect((robot.rig_dir / "tty").read_text().strip())
        line.sendall(json.dumps({"do": "new_rail"}).encode() + b"\n")
    wait_for(lambda: queue.tick(SYSTEM.now()) or Job.objects.filter(pk=job.pk, state="failed").exists(), 30, "its end")
    job.refresh_from_db()
    return job


def test_a_robot_that_nobody_drives_serves_two_guests_fairly_and_recharges(transactional_db, redis_server, monkeypatch):
    bus.connection().flushall()
    shutil.rmtree(settings.VAR / "run", ignore_errors=True)
    with installed_from(SHUTTLE, monkeypatch):
        robot = add_robot("shuttle")
        shutil.rmtree(robot.rig_dir, ignore_errors=True)
        children = []
        try:
            for spec in robot_processes(robot):
                children.append(Child(spec.name.replace(" ", "-"), list(spec.argv), **spec.env))
            wait_for(lambda: Robot.objects.get(pk=robot.pk).cycle == Cycle.READY, 60, "the robot is in order")
            guests = [Guest("192.0.2.1", [1.0] * GOALS), Guest("2001:db8::1", [0.0] * GOALS)]

            def served():
                done = [guest.go_on() for guest in guests]
                queue.tick(SYSTEM.now())
                return all(done)

            wait_for(served, 120, "both guests are served")
            lost = [Guest("192.0.2.7", [1.75]), Guest("192.0.2.8", [1.25])]
            wait_for(lambda: all([g.go_on() for g in lost]) or queue.tick(SYSTEM.now()), 30, "both are told why not")
            wait_for(lambda: queue.tick(SYSTEM.now()) or Grant.objects.filter(kind="idle").exists(), 20, "it roams")
            dropped = left_behind(robot)
        finally:
            for child in children[::-1]:
                child.kill()
        journal = [json.loads(line) for line in (robot.rig_dir / "journal.jsonl").read_text().splitlines()]
        told = Client().get("/robots/shuttle/statistics.json").json()
    rows = {row["label"]: row["value"] for row in told["rows"]}
    ends = [rows[name] for name in ("Trips arrived", "Given up by the robot", "Refused by the robot")]
    assert ends == [2 * GOALS, 1, 1]
    assert rows["Recharges"] == Command.objects.filter(kind="dock", state="completed").count() >= 1
    assert sum(one["attempted"] for one in told["success"]["bins"]) == 2 * GOALS + 1, "its battery was read at each"
    assert rows["Driven"] is None, "it tells no such value, so none is invented"
    assert Frame.objects.filter(robot=robot, width=128, height=16).exists(), "its pictures come by its driver"
    refused, gave_up = (guest.job for guest in lost)
    assert (dropped.code, dropped.charged, dropped.runs.count()) == ("rail", 0.0, 0)
    assert rows["Dropped, because the rail was taken away"] == 1
    assert (refused.state, refused.reason) == ("failed", "The rail ends before this place today.")
    assert (gave_up.state, gave_up.reason) == ("failed", "A leaf lies on the rail here.")
    assert (refused.charged, gave_up.charged) == (0.0, 1.0)
    served = [j for j in Job.objects.order_by("ended_at") if j not in (refused, gave_up, dropped)]
    assert [(j.state, j.reason) for j in served if j.state != "done"] == []
    order = [j.account.network for j in served]
    first, second = order[:2]
    assert order == [first, second] * GOALS, "each in turn"
    theirs = Account.objects.filter(network__in=(first, second))
    assert {a.finish_tag for a in theirs} == {float(GOALS)}
    asked = [note["do"] for note in journal if note["do"] in ("go", "dock")]
    # on a busy machine a fault may cut a job short, which then goes on in another run
    assert 2 * GOALS <= asked.count("go") <= JobRun.objects.count(), "one motion a run"
    assert "dock" in asked[:-1], "it recharged in between"
    assert min(note["battery"] for note in journal if note["do"] == "go") >= 0.3
    assert Command.objects.filter(grant=None).count() == 0
    assert set(Grant.objects.values_list("kind", flat=True)) <= {"handover", "job", "upkeep", "idle"}
