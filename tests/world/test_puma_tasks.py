"""Tasks of the PUMA 560 in virtual time, judged by the simulator's own positions of its bricks and its rod."""

import pytest

from robots.kit.arms.beliefs import How
from robots.kit.description import programs_of
from tests.world.seeds import hunts
from tests.world.test_tasks import begin, beliefs, blocks, run

pytestmark = pytest.mark.parametrize("which", ["puma"], indirect=True)
GALLERY = dict(programs_of("puma", "task"))
BRICK_M, NEAR_M = 0.0192, 0.001


@hunts(1, 5, 20)
def test_bricks_that_are_put_on_each_other_clutch_to_a_tower(portal):
    """The bricks lie 1 mm beside their places in the description, and clutch all the same: the fingers centre them."""
    command = run(portal, GALLERY["Tower of three"])
    assert (command.state, command.reason) == ("completed", "")
    assert (command.ended_at - command.created_at).total_seconds() < 60
    there = blocks(portal)
    a, b, c = (there[name] for name in "abc")
    assert b == pytest.approx([*a[:2], a[2] + BRICK_M], abs=NEAR_M)
    assert c == pytest.approx([*a[:2], a[2] + 2 * BRICK_M], abs=NEAR_M)
    assert beliefs(portal)["c"]["how"] == How.ARM


@hunts(1, 5, 20)
def test_the_rod_is_grasped_lifted_and_let_go_on_its_threads(portal):
    command = begin(portal, GALLERY["The rod, lifted"])
    portal.until(lambda: blocks(portal)["rod"][2] > 0.335, 60, "the rod, lifted")
    command = portal.final(command, 120)
    assert (command.state, command.reason) == ("completed", "")
    assert blocks(portal)["rod"][2] == pytest.approx(0.30, abs=0.01)


@hunts(1, 3, 20)
def test_a_stop_in_mid_task_rests_the_arm_and_nothing_goes_on(portal):
    command = begin(portal, GALLERY["Tower of three"])
    portal.until(lambda: portal.rig.moving, 60, "the arm moves")
    portal.stop()
    command = portal.final(command)
    assert command.state in ("failed", "cancelled"), f"{command.state}: {command.reason}"
    moved = portal.rig.count("motion")
    portal.world.sleep(30)
    assert portal.rig.count("motion") == moved
    assert not portal.rig.moving
