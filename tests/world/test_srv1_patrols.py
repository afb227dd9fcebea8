"""The hall rover's patrol around its map, and its place: where it may go from there, and after somebody carried it."""

import random
from math import dist

import pytest

from robots.kit.drivers.srv1.hall import hall
from tests.world.seeds import hunts

pytestmark = pytest.mark.parametrize("which", ["srv1"], indirect=True)
PLACE = hall().nodes[1].at


@hunts(1, 10, 100)
def test_it_goes_where_it_is_sent_also_when_it_was_carried_off(portal):
    """Somebody carries it off while it is on, and its odometry does not notice: it is not where it says for long."""
    portal.grant()
    dice, plant = random.Random(portal.world.seed), portal.rig.sim.world.plant
    assert portal.final(portal.issue("look"), 200).state == "completed"
    node = dice.choice([node for node in hall().nodes if dist(node.at, PLACE) > 2])
    plant.put(*node.at, plant.pose[2] + dice.uniform(-0.3, 0.3))
    command = portal.final(portal.issue("go", x=PLACE[0], y=PLACE[1]), 400)
    assert command.state == "completed", command.reason
    assert dist(plant.pose[:2], PLACE) < 0.25, "it is where it was sent"
    assert plant.contacts == ()


@hunts(1, 10, 100)
def test_from_a_patrol_it_goes_where_it_is_sent(portal):
    """A patrol leads around the map and touches nothing; from wherever it ends, the rover goes where it is sent."""
    plant, touched = portal.rig.sim.world.plant, set()
    portal.grant()
    for _ in range(3):
        command = portal.issue("patrol")
        for _ in range(4 * 59):
            portal.world.sleep(0.25)
            touched |= set(plant.contacts)
        assert portal.final(command).state == "completed", command.reason
        shown = portal.owner.owned.driver.state()
        if shown.pose:
            assert dist(shown.pose[:2], plant.pose[:2]) <= max(0.1, 1.5 * shown.values["spread"])
    assert touched == set()
    place = random.Random(portal.world.seed).choice(hall().nodes).at
    command = portal.final(portal.issue("go", x=place[0], y=place[1]), 300)
    assert command.state == "completed", command.reason
