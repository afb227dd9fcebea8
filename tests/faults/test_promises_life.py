"""Promises 25 and 26: upgrade, restore, and a stop of everything in mid-motion."""

import os
import signal
import sqlite3
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import pytest
from django.conf import settings
from django.core.management import call_command
from django.db import connection, models

from operatorlog.models import SurveyQuestion
from portal.keep import archive
from portal.keep import restore as restoring
from robots.models import Command, Frame, Robot
from tests import migrated
from tests.conftest import wait_for
from tests.faults.test_promises_data import write_down
from tests.rig import ROOT, Simulator, free_port

# ruff: noqa: TID251 - its tests are timed
pytestmark = pytest.mark.timed


def test_promise_25_restore_brings_everything_back(rig, proof, tmp_path):
    """A timed drill: back up while somebody drives, empty everything, restore, compare."""
    rows = proof.count("log entries with turns", 30, 1500)
    rig.owner()
    rig.grant()
    rig.final(rig.issue("move", x=0.1, y=0.4))
    question = SurveyQuestion.objects.create(prompt="How was it?", kind=SurveyQuestion.Kind.TEXT)
    for i in range(rows):
        write_down(rig, f"entry {i}", question)
    rig.slow(0.1)  # it is under way until the backup has read it
    command = rig.issue("move", x=-0.2, y=0.3)
    rig.moving()
    manifest = archive.write(tmp_path / "backup.tar.gz")
    assert rig.final(command).state == "completed", "the backup disturbed the one who drives"
    for child in rig.workers:
        child.stop()
    before = archive.counts()
    hashes = archive.media_hashes(Path(settings.MEDIA_ROOT))
    call_command("flush", interactive=False, verbosity=0)
    for file in Path(settings.MEDIA_ROOT).rglob("*.jpg"):
        file.unlink()
    begun = time.monotonic()
    call_command("restore", str(tmp_path / "backup.tar.gz"), verbosity=0)
    seconds = time.monotonic() - begun
    assert archive.counts() == manifest["rows"] | {k: v for k, v in before.items() if k not in manifest["rows"]}
    found = archive.media_hashes(Path(settings.MEDIA_ROOT))
    assert all(found[name] == digest == hashes[name] for name, digest in manifest["media"].items())
    assert Frame.objects.exists()
    assert Command.objects.get(pk=command.pk).state == "unknown", "it was under way at the backup"
    assert Robot.objects.get().cycle == "offline"
    rig.robot = Robot.objects.get()
    rig.start_worker()
    rig.wait_ready()
    assert rig.lease().epoch > restoring.EPOCHS_AHEAD
    assert seconds < 900
    total = sum(manifest["rows"].values())
    proof.holds(f"{total} rows and {len(manifest['media'])} pictures equal after {seconds:.1f} s")


def test_promise_25_a_migration_while_a_turn_is_open(rig, proof):
    """A column is added under the running worker and web tier, as an update would; the turn goes on."""
    proof.count("migrations under an open turn", 1, 1)
    worker = rig.owner()
    rig.grant()
    field = models.CharField(max_length=20, default="", db_default="")
    field.set_attributes_from_name("of_tomorrow")
    field.model = Command
    command = rig.issue("move", x=-0.2, y=0.3)
    rig.moving()
    with connection.schema_editor() as editor:
        editor.add_field(Command, field)
    try:
        assert rig.final(command).state == "completed", command.reason
        assert rig.final(rig.issue("move", x=0.1, y=0.4)).state == "completed", "the old code goes on"
        assert worker.alive()
    finally:
        for child in rig.workers:
            child.stop()
        with connection.schema_editor() as editor:
            editor.remove_field(Command, field)
    proof.holds("a column added in mid-motion: the motion completed, the next one too, no restart")


def processes_of(folder):
    """Return the processes that have `folder` in their command line or environment."""
    found = []
    for path in Path("/proc").glob("[0-9]*"):
        try:
            text = (path / "cmdline").read_bytes() + (path / "environ").read_bytes()
        except OSError:
            continue
        if str(folder).encode() in text and int(path.name) != os.getpid():
            found.append(path.name)
    return found


def test_promise_26_a_stop_of_everything_in_mid_motion_is_safe(proof):
    """SIGTERM to the supervisor: a held robot, a recorded command, exit 0, nothing left, within 20 s."""
    times = proof.count("stops in mid-motion", 1, 5, 20)
    slowest = 0.0
    for i in range(times):
        with tempfile.TemporaryDirectory(prefix="fh-life-") as folder:
            slowest = max(slowest, _life(Path(folder), i))
    assert slowest < 20
    proof.holds(
        f"{times} stops: exit 0, robot held, command recorded, no process or lock left; {slowest:.1f} s at most"
    )


DRIVE = """
import django
django.setup()
from accounts.models import Clearance, User
from queueing import services as queue
from queueing.errors import QueueError
from robots import services
from robots.kit.clock import SYSTEM
from robots.models import Robot
from robots.states import COMMAND_FINAL
admin, robot, turn = User.objects.get(username="admin"), Robot.objects.get(slug="mercury"), None
Clearance.objects.create(user=admin, robot=robot, granted_at=SYSTEM.now())
while turn is None:  # on a busy machine an offer may be taken back, because the robot was out of reach
    queue.join(robot, admin, SYSTEM.now())
    SYSTEM.sleep(0.2)
    try:
        turn = queue.accept(robot, admin, SYSTEM.now())
    except QueueError as error:
        print(error)
slow = services.issue("mercury", admin, "speed", {"speed": 0.02}, 1).command
while slow.state not in COMMAND_FINAL:  # a motion that lasts until everything is stopped
    SYSTEM.sleep(0.1)
    slow.refresh_from_db()
assert slow.state == "completed", slow.reason
move = services.issue("mercury", admin, "move", {"x": -0.2, "y": 0.3}, 2).command
while move.state != "acknowledged":
    SYSTEM.sleep(0.1)
    move.refresh_from_db()
    assert move.state not in COMMAND_FINAL, (move.state, move.reason)
"""


def _life(folder, number):
    env = {k: v for k, v in os.environ.items() if k not in ("REDIS_URL", "DATABASE_URL")}
    env |= {"FARHAND_VAR": str(folder), "DJANGO_SETTINGS_MODULE": "portal.settings"}
    migrated.begin(folder / "farhand.sqlite3")
    port = free_port()
    with (folder / "demo.log").open("wb") as out:
        demo = subprocess.Popen(
            [sys.executable, "manage.py", "demo", "--port", str(port)], cwd=ROOT, env=env, stdout=out, stderr=out
        )
    try:

        def cycle():
            try:
                with sqlite3.connect(f"file:{folder}/farhand.sqlite3?mode=ro", uri=True) as db:
                    return db.execute("select cycle from robots_robot where slug = 'mercury'").fetchone()
            except sqlite3.OperationalError:
                return None

        wait_for(lambda: cycle() == ("ready",), 120, "the demo is ready")
        drive = [sys.executable, "-c", DRIVE]
        driven = subprocess.run(drive, cwd=ROOT, env=env, capture_output=True, text=True, timeout=120)
        assert driven.returncode == 0, driven.stderr
        sim = Simulator.__new__(Simulator)
        sim.folder, sim._counted, sim._read = folder / "sim" / "mercury", {}, 0
        wait_for(lambda: sim.status()["moving"], 10, "a motion")
        begun = time.monotonic()
        demo.send_signal(signal.SIGTERM)
        assert demo.wait(25) == 0
        seconds = time.monotonic() - begun
    finally:
        demo.kill()
    journal = sim.journal()
    told = [(r["event"], round(r["t"] - begun, 2), r.get("braked")) for r in journal[-4:]]
    rest = [r for r in journal if r["event"] == "rest"][-1]
    assert rest["braked"], f"not held: {told}, {seconds:.1f} s, {(folder / 'demo.log').read_text()[-1500:]}"
    with sqlite3.connect(folder / "farhand.sqlite3") as db:
        state, reason = db.execute("select state, reason from robots_command where kind = 'move'").fetchone()
        epoch_over = db.execute(
            "select min(expires_at <= strftime('%Y-%m-%d %H:%M:%f', 'now')) from robots_lease"
        ).fetchone()[0]
    assert state in ("cancelled", "unknown"), state
    assert reason
    assert epoch_over, "the lease was given back"
    wait_for(lambda: not processes_of(folder), 10, "the end of what it had forked, which hears of its own")
    return seconds
