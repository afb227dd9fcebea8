"""A new owner finds a robot that is not ready, in a turn, with a stop that nobody heard: only a command moves it."""

import pytest

from robots import services
from robots.models import Incident, Robot
from tests.conftest import wait_for
from workers.robot.recovery import MENDED

pytestmark = pytest.mark.timed


def test_what_was_stopped_while_nobody_owned_the_robot_is_moved_by_a_command_alone(rig):
    first = rig.owner()
    rig.grant()
    assert rig.final(rig.issue("up")).state == "completed"
    first.kill()
    rig.sim.power_cycle()
    rig.sim.forget()
    services.stop(rig.robot, rig.people["kim"], rig.now())
    epoch = rig.lease().epoch
    rig.start_worker()
    wait_for(lambda: rig.lease().epoch > epoch, 20, "the next owner")
    wait_for(lambda: rig.reason() == "The robot is stopped.", 20, "the attempt to reset it")
    wait_for(lambda: Robot.objects.get().stop_confirmed, 10, "the robot's word that it rests")
    rig.swept()
    assert (rig.sim.count("motion"), rig.sim.count("calibrate")) == (0, 0)
    assert [found.code for found in Incident.objects.all()] == ["hardware_fault"]
    services.release_stop(rig.robot, rig.people["kim"], checked=True)
    wait_for(lambda: rig.reason() == "", 30, "the owner is back")
    rig.swept()
    assert (rig.sim.count("motion"), rig.sim.count("calibrate")) == (0, 0), "a release starts no motion"
    assert rig.final(rig.issue("down")).state == "failed"
    wait_for(lambda: rig.sim.count("calibrate") == 1, 30, "the reset")
    wait_for(Incident.objects.filter(remedy=MENDED).exists, 30, "its end")  # a command that waits long expires
    wait_for(lambda: rig.reason() == "", 30, "the robot is well")
    assert rig.final(rig.issue("down")).state == "completed", "the turn goes on"
