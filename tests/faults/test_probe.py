"""The admin's test of a connection, through the housekeeping worker as in life."""

import shutil
from pathlib import Path

import pytest
from django.conf import settings

from robots import bus
from robots.models import Robot
from tests.conftest import wait_for
from tests.rig import Simulator, housekeeping


@pytest.fixture
def broom(transactional_db, redis_server, robot, people):
    bus.connection().flushall()
    Robot.objects.update(enabled=False)
    shutil.rmtree(robot.rig_dir, ignore_errors=True)
    robot.rig_dir.mkdir(parents=True)
    child = housekeeping()
    yield child
    child.kill()


def probe(robot):
    Robot.objects.filter(pk=robot.pk).update(probe={})
    bus.send_housekeeping("robots.probe", robot.slug)
    found = {}

    def done():
        found.update(Robot.objects.get(pk=robot.pk).probe)
        return bool(found)

    wait_for(done, 60, "the probe")
    return found


def simulators(robot):
    """Return the simulators of this robot that run, as the kernel tells."""
    lines = [p.read_bytes() for p in Path("/proc").glob("[0-9]*/cmdline")]
    return [line for line in lines if str(robot.rig_dir).encode() in line]


def test_a_robot_that_is_switched_off_is_tested_and_left_as_it_was(broom, robot):
    found = probe(robot)
    assert (found["connection"], found["picture"]) == ("ok", "ok")
    assert len(found["state"]["pose"]) == 4
    assert (Path(settings.MEDIA_ROOT) / found["file"]).stat().st_size > 500
    wait_for(lambda: not simulators(robot), 10, "no simulator is left")


def test_what_does_not_answer_is_named(broom, robot):
    Robot.objects.update(address="serial:/dev/ttyNOWHERE", camera="http://127.0.0.1:9/snapshot.jpg")
    found = probe(robot)
    assert found["connection"] == "The robot's serial port cannot be opened."
    assert found["picture"] == "The camera does not answer."


def test_a_controller_that_is_silent_is_named(broom, robot):
    Robot.objects.update(enabled=True)  # so that the probe starts no simulator of its own
    sim = Simulator(robot.rig_dir)
    try:
        sim.fault("awol")
        found = probe(robot)
        assert "did not answer" in found["connection"]
        assert found["picture"] == "ok"
    finally:
        sim.stop()
