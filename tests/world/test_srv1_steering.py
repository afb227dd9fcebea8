"""The hall rover steered by a held stick: the latest value wins, a refused one counts for nothing."""

import random
from math import inf, nan

import pytest

from robots import bus
from tests.world.seeds import hunts

pytestmark = pytest.mark.parametrize("which", ["srv1"], indirect=True)
SOON_S = 1.0  # a keep-alive, a velocity, the way from one to the other, and how fast the rims change
BAD = ({"forward": 1.01}, {"forward": nan}, {"forward": 1e308}, {"turn": -inf}, {"sideways": 0.1})


def driving(portal):
    portal.grant()
    portal.controls.moment_s = inf
    command = portal.controls.hold(portal.issue("drive", forward=0.5, turn=0.0))
    portal.in_motion()
    return command


def target(portal):
    """Return m/s ahead and rad/s to the left that the motors follow."""
    left, right = portal.rig.sim.world.drive.target
    return (left + right) / 2, (right - left) / 0.2


@hunts(2, 20, 200)
def test_the_latest_value_wins(portal):
    command = driving(portal)
    dice = random.Random(portal.world.seed)
    for _ in range(4):
        forward, turn = (round(dice.uniform(-0.4, 0.4), 2) for _ in "vw")
        portal.controls.args = {"forward": forward, "turn": turn}
        portal.world.sleep(SOON_S)
        ahead, turning = target(portal)
        assert abs(ahead - 0.4 * forward) < 0.02
        assert abs(turning - turn) < 0.05
    bus.send_keep_alive(portal.slug, command.pk + 1, True, {"forward": 1.0, "turn": 0.0})  # of another page
    portal.world.sleep(0.3)
    assert abs(target(portal)[0] - 0.4 * forward) < 0.02
    portal.controls.args = {"forward": 0.0, "turn": 0.0}
    portal.at_rest(1.0)
    portal.world.sleep(0.5)
    portal.controls.args = {"turn": 1.0}
    portal.in_motion()
    portal.controls.moment_s = 0.0
    assert portal.final(command).state == "completed"
    portal.at_rest(1.0)


@hunts(5, 10, 50)
def test_values_that_are_refused_end_the_motion(portal):
    command = driving(portal)
    at = portal.world.monotonic()
    portal.controls.args = BAD[portal.world.seed % len(BAD)]
    portal.at_rest(1.0)
    assert portal.world.monotonic() - at <= 0.06 + 0.25 + 0.5
    assert portal.final(command).state == "cancelled"
    begun = portal.rig.count("motion")
    portal.controls.args = {"forward": 0.5}
    portal.world.sleep(1.0)
    assert portal.rig.count("motion") == begun


@hunts(1, 10, 50)
def test_one_that_is_refused_among_others_changes_nothing(portal):
    command = driving(portal)
    for bad in BAD:
        bus.send_keep_alive(portal.slug, command.pk, True, bad)
        portal.world.sleep(0.2)
    ahead, turning = target(portal)
    assert (round(ahead, 2), round(turning, 2)) == (0.2, 0.0)
    portal.controls.let_go()
    portal.at_rest(1.0)
    portal.final(command)
