"""The museum arm recognises its blocks by their colours, in virtual time, judged by the simulator's own positions."""

import pytest

from robots.kit.arms.beliefs import How
from tests.world.seeds import hunts
from tests.world.test_picking import EMPTY_PLACE, FIRST, done, move_by_hand
from tests.world.test_tasks import beliefs, blocks, near, run

pytestmark = [pytest.mark.parametrize("which", ["pa10"], indirect=True), pytest.mark.usefixtures("sharp")]


@hunts(1, 3, 10)
def test_a_turn_begins_with_the_blocks_where_pictures_show_them(portal):
    portal.ready()
    for name, at in FIRST.items():
        assert beliefs(portal)[name]["how"] == How.MEASURED, name
        assert near(beliefs(portal)[name]["place"], [*at, 0.02]), name


@hunts(1, 5, 20)
def test_a_block_that_somebody_moved_is_seen_where_it_is_before_it_is_picked_up(portal):
    portal.grant()
    move_by_hand(portal, "red", *EMPTY_PLACE)
    done(portal, "pick", EMPTY_PLACE)
    assert beliefs(portal)["red"]["held"]
    done(portal, "put", FIRST["yellow"])
    assert blocks(portal)["red"] == pytest.approx([*blocks(portal)["yellow"][:2], 0.06], abs=0.008)
    assert near(blocks(portal)["yellow"], [*FIRST["yellow"], 0.02])


@hunts(1, 3, 10)
def test_a_tower_is_built_and_seen(portal):
    command = run(portal, "put red on yellow\nput blue on red\nexpect blue on red")
    assert (command.state, command.reason) == ("completed", "")
    there = blocks(portal)
    assert near(there["blue"], [*there["yellow"][:2], 0.10])
    assert near(beliefs(portal)["blue"]["place"], there["blue"])
