"""An owner that was suspended for longer than its lease goes on in the same process if no other replaced it."""

import signal
import time

import pytest
from celery import current_app

from robots import bus
from robots.models import Robot
from tests.conftest import wait_for

# ruff: noqa: TID251 - its tests are timed
pytestmark = pytest.mark.timed


def test_a_lapsed_lease_is_taken_again_in_the_same_process(rig):
    owner = rig.owner()
    rig.grant(seconds=3000)
    rig.slow()
    command = rig.issue("move", x=-0.2, y=0.3)
    rig.moving()
    epoch = rig.lease().epoch
    owner.signal(signal.SIGSTOP)
    time.sleep(4.0)
    owner.signal(signal.SIGCONT)
    assert rig.final(command).state == "unknown"
    wait_for(lambda: rig.lease().epoch == epoch + 1, 10, "the new epoch")
    assert (owner.alive(), rig.lease().pid) == (True, owner.pid)
    before = rig.sim.count("motion")
    Robot.objects.update(settings={})
    rig.share = None
    rig.robot_shows(lambda status: not status["moving"], 10, "the hold")
    rig.swept()
    assert rig.sim.count("motion") == before, "nothing is repeated"

    def works():
        return rig.final(rig.issue("move", x=0.0, y=0.45)).state == "completed"

    wait_for(works, 20, "the turn goes on")
    old, new = bus.queue_name(rig.robot.slug, epoch), bus.queue_name(rig.robot.slug, epoch + 1)
    for queue in (old, new):
        current_app.send_task(bus.WAKE_TASK, queue=queue, ignore_result=True, retry=False)
    wait_for(lambda: bus.connection().llen(new) == 0, 5, "the new queue is listened to")
    assert bus.connection().llen(old) == 1, "the old one is not"


def test_the_process_outlives_many_lapses(rig):
    owner = rig.owner()
    rig.grant(seconds=3000)
    epoch = rig.lease().epoch
    for lapse in (1, 2, 3):
        owner.signal(signal.SIGSTOP)
        time.sleep(3.5)
        owner.signal(signal.SIGCONT)
        wait_for(lambda lapse=lapse: rig.lease().epoch == epoch + lapse, 10, "the new epoch")
    wait_for(lambda: rig.final(rig.issue("noop")).state == "completed", 15, "it works")
    assert owner.alive()
