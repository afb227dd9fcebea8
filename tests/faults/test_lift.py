"""A real owner and simulator: lifting a lock-out moves nothing, nor does the release; the next command does."""

import pytest

from robots import services
from robots.models import Robot
from robots.states import Cycle
from tests.conftest import at_length, wait_for

pytestmark = pytest.mark.timed


@pytest.mark.parametrize("which", ["pa10", at_length("mercury"), at_length("irat")], indirect=True)
def test_a_lift_leaves_the_robot_where_it_stands_until_a_command_after_the_release(rig):
    rig.owner()
    rig.grant(seconds=600)
    rig.done("move", x=0.2, y=0.4)
    services.lock_out(rig.robot, rig.people["kim"], "hands in the cell")
    wait_for(lambda: Robot.objects.get().stop_confirmed and not rig.sim.status()["moving"], 20, "rest")
    rig.sim.forget()
    services.lift_lock_out(rig.robot, rig.people["kim"])
    wait_for(lambda: rig.cycle() == Cycle.READY, 60, "the robot is verified")
    rig.swept()
    assert rig.sim.count("motion") == 0
    assert Robot.objects.get().stop_latched
    services.release_stop(rig.robot, rig.people["kim"], checked=True)
    rig.swept()
    assert rig.sim.count("motion") == 0
    assert rig.cycle() == Cycle.READY
    rig.grant(seconds=600)
    rig.done("move", x=-0.2, y=0.4)
    assert rig.sim.count("motion") > 0
