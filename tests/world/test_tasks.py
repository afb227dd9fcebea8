"""Tasks of the museum arm in virtual time, judged by the simulator's own positions of its blocks."""

import json

import pytest

from robots.kit.arms.beliefs import How
from robots.models import Command
from tests.world.seeds import hunts

pytestmark = pytest.mark.parametrize("which", ["pa10"], indirect=True)
TOWER = "# three blocks\ngrasp red\nput red on yellow\ngrasp blue\nput blue on red\nexpect blue on red"
NEAR_M = 0.004


def blocks(portal):
    """Return where the simulated blocks are (m)."""
    return portal.rig.sim.status()["objects"]


def model(portal):
    return portal.owner.owned.driver.tasks.model


def begin(portal, text):
    portal.grant()
    return portal.issue("task", text=text)


def run(portal, text):
    return portal.final(begin(portal, text), 120)


def near(one, other):
    return one == pytest.approx(other, abs=NEAR_M)


@hunts(1, 5, 20)
def test_a_tower_of_three_stands_at_the_end_of_its_task(portal):
    command = run(portal, TOWER)
    assert (command.state, command.reason) == ("completed", "")
    assert Command.objects.filter(kind="task").count() == 1
    there = blocks(portal)
    assert near(there["red"], [*there["yellow"][:2], 0.06])
    assert near(there["blue"], [*there["yellow"][:2], 0.10])
    for name in ("red", "blue", "yellow"):
        assert near(list(model(portal).belief(name).place), there[name]), name
    assert model(portal).belief("red").how == How.ARM
    assert model(portal).belief("green").how == How.START
    assert command.progress["text"] == "line 6 of 6: expect blue on red"
