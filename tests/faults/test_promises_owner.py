"""Promise 4 with real processes: the kernel kills, freezes and locks as the tests in virtual time say that it does."""

import shutil
import signal
import time

import pytest
from django.conf import settings
from django.db import connection

from robots.models import Lease, Robot
from tests.conftest import wait_for
from tests.rig import Simulator, free_port
from tests.waiting import CEILING_S

# ruff: noqa: TID251 - its tests are timed
pytestmark = pytest.mark.timed


@pytest.mark.parametrize("which", ["mercury"], indirect=True)
def test_promise_04_a_frozen_owner_is_killed_and_says_nothing_more(rig, proof):
    """SIGSTOP beyond the lease, another takes over, SIGCONT: no byte of the first reaches the robot."""
    times = proof.count("take-overs", 1, 12, 200)
    slowest = 0.0
    owner = rig.owner()
    rig.grant(seconds=3000)
    rig.slow(0.1)  # it is under way when its owner is frozen
    rig.share = 0.3
    for i in range(times):
        command = rig.issue("move", x=0.2 if i % 2 else -0.2, y=0.32)
        rig.moving()
        owner.signal(signal.SIGSTOP)
        frozen = time.monotonic()
        frames = rig.sim.status()["counts"].get("frame", 0)
        epoch = rig.lease().epoch
        second = rig.start_worker()
        wait_for(lambda epoch=epoch: rig.lease().epoch > epoch, 30, "the take-over")
        slowest = max(slowest, time.monotonic() - frozen)
        assert owner.process.wait(CEILING_S) == -signal.SIGKILL, "the taker kills it first"
        owner.signal(signal.SIGCONT)
        command = rig.final(command, 30)
        assert command.state == "unknown"
        before = rig.sim.count("motion")
        rig.swept()
        assert rig.sim.count("motion") == before
        assert rig.done("move", x=0.0, y=0.5).state == "completed"
        assert frames <= rig.sim.status()["counts"].get("frame", 0)
        owner = second
    proof.holds(f"{times} frozen owners killed by their takers, 0 motions of theirs after; take-over {slowest:.1f} s")


def test_promise_04_a_stale_epoch_is_refused_at_the_driver_and_by_the_robot(rig, proof):
    """The lock is taken away and the line is TCP, so the first cannot be killed and goes on: refused."""
    if connection.vendor != "postgresql":
        pytest.skip("owners on several hosts need PostgreSQL")
    times = proof.count("stale owners", 1, 6, 200)
    port = free_port()
    rig.sim.stop()
    shutil.rmtree(rig.sim.folder)
    rig.sim.folder.mkdir(parents=True)
    rig.sim = Simulator(rig.sim.folder, tcp=port)
    camera = (rig.sim.folder / "camera").read_text().strip() + "/snapshot.jpg"
    Robot.objects.update(address=f"tcp:127.0.0.1:{port}", camera=camera, cycle="offline")  # until it is put in order
    for i in range(times):
        first = rig.start_worker(doom="SIGSTOP")
        wait_for(lambda: Robot.objects.get().cycle in ("ready", "operating") and alive(rig), 60, "the first")
        if i == 0:
            rig.grant(seconds=3000)
        before, refused = rig.sim.count("motion"), rig.sim.count("refused")
        command = rig.issue("move", x=0.2 if i % 2 else -0.2, y=0.33)
        wait_for(lambda first=first: state_of(first.pid) == "T", 20, "the first freezes before it sends")
        Lease.objects.update(host="elsewhere")  # nobody here may kill it
        (settings.VAR / "run" / "mercury.lock").unlink()
        epoch = rig.lease().epoch
        second = rig.start_worker()
        wait_for(lambda epoch=epoch: rig.lease().epoch > epoch, 30, "the take-over")
        wait_for(lambda refused=refused: rig.sim.count("refused") > refused, 20, "the second tries the line")
        assert first.alive()
        first.signal(signal.SIGCONT)
        wait_for(lambda first=first: not first.alive(), 15, "the first leaves")
        command = rig.final(command, 20)
        assert rig.sim.count("motion") == before, "the stale owner moved the robot"
        wait_for(lambda: not Robot.objects.get().reason, 30, "the second reaches the robot")
        again = rig.final(rig.issue("move", x=0.0, y=0.5))
        assert again.state == "completed", again.reason
        second.stop()
        Lease.objects.update(host="")
    proof.holds(f"{times} stale owners went on: 0 motions; the robot turned {rig.sim.count('refused')} clients away")


def alive(rig):
    from robots.grants import owner_alive
    from robots.kit.clock import SYSTEM

    return owner_alive(rig.lease(), SYSTEM.now())


def state_of(pid):
    """Return the kernel's letter for a process: T while stopped."""
    from pathlib import Path

    return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
