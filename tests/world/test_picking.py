"""Pick and put by places on the museum arm's table in virtual time, judged by the simulator's own positions."""

import random

import pytest

from robots.kit.arms.beliefs import How
from tests.world.seeds import hunts
from tests.world.test_tasks import beliefs, blocks, near

pytestmark = pytest.mark.parametrize("which", ["pa10"], indirect=True)
FIRST = {"red": (0.50, 0.16), "yellow": (0.56, 0.05), "blue": (0.50, -0.08), "green": (0.60, -0.18)}
EMPTY_PLACE = (0.45, 0.28)  # of the table: no block lies there at first
BLOCK_M = 0.04


def act(portal, kind, at):
    return portal.final(portal.issue(kind, x=at[0], y=at[1]))


def done(portal, kind, at):
    command = act(portal, kind, at)
    assert (command.state, command.reason) == ("completed", ""), f"{kind} at {at}"


def holds_red(portal):
    """Tell what the arm believes; before anything has changed it has stored nothing."""
    return (portal.rig.folder / "objects.json").exists() and beliefs(portal)["red"]["held"]


def move_by_hand(portal, name, x, y):
    """Move a block as somebody beside the table does, of which the arm learns nothing."""
    plant = portal.rig.sim.plant
    at = int(plant.model.joint(f"{name}_free").qposadr[0])
    plant.data.qpos[at : at + 3] = x, y, BLOCK_M / 2
    portal.rig.sim._shared.write(plant.qpos)  # for the cameras: the loop that does it pauses at rest


@hunts(1, 10, 50)
def test_blocks_are_picked_up_and_put_down_at_many_places(portal):
    """A click beside a block's middle takes that block, and one on a block puts another on its top."""
    dice = random.Random(portal.world.seed)
    portal.grant()
    where = {name: (*at, 0.0) for name, at in FIRST.items()}
    for _ in range(4):
        name = dice.choice([one for one in where if not lies_under(where, one)])
        x, y, _ = where[name]
        done(portal, "pick", (x + dice.uniform(-0.015, 0.015), y + dice.uniform(-0.015, 0.015)))
        portal.until(lambda n=name: blocks(portal)[n][2] > 0.08, 5, "a lifted block")
        del where[name]
        other = dice.choice(list(where))
        if dice.random() < 0.5 and not lies_under(where, other):
            to = (*where[other][:2], where[other][2] + BLOCK_M)
        else:
            to = (*free_place(dice, where), 0.0)
        done(portal, "put", to[:2])
        where[name] = to
        assert near(blocks(portal)[name], [*to[:2], to[2] + BLOCK_M / 2]), name
        assert beliefs(portal)[name]["how"] == How.ARM


def lies_under(where, name):
    x, y, bottom = where[name]
    return any((a, b) == (x, y) and low > bottom for a, b, low in where.values())


def free_place(dice, where):
    while True:
        at = dice.uniform(0.40, 0.62), dice.uniform(-0.30, 0.30)
        if all(abs(at[0] - x) > 0.09 or abs(at[1] - y) > 0.13 for x, y, _ in where.values()):
            return at


@hunts(1, 5, 20)
def test_where_nothing_lies_the_gripper_says_that_it_is_empty_and_comes_up_again(portal):
    portal.grant()
    command = act(portal, "pick", EMPTY_PLACE)
    assert (command.state, command.reason) == ("failed", "The gripper is empty: nothing was there.")
    assert blocks(portal)["tip"][2] > 0.09, "it has come up again"
    command = act(portal, "put", EMPTY_PLACE)
    assert (command.state, command.reason) == ("rejected", "The gripper holds nothing. Pick something up first.")
    done(portal, "pick", FIRST["red"])


@hunts(1, 5, 20)
def test_a_block_that_somebody_moved_is_found_by_the_gripper_where_it_is_seen(portal):
    """It is missed where it was believed to be; then the one block whose place is not known is what is felt there."""
    portal.grant()
    move_by_hand(portal, "red", *EMPTY_PLACE)
    command = act(portal, "pick", FIRST["red"])
    assert (command.state, command.reason) == ("failed", "The gripper is empty: red was not there.")
    assert beliefs(portal)["red"]["how"] == How.MISSED
    assert blocks(portal)["tip"][2] > 0.09
    done(portal, "pick", EMPTY_PLACE)
    assert beliefs(portal)["red"]["held"]
    done(portal, "put", FIRST["yellow"])
    assert near(blocks(portal)["red"], [*FIRST["yellow"], 1.5 * BLOCK_M])


@hunts(1, 5, 20)
def test_what_the_arm_cannot_name_is_left_where_it_is(portal):
    portal.grant()
    move_by_hand(portal, "red", *EMPTY_PLACE)
    command = act(portal, "pick", EMPTY_PLACE)
    assert command.state == "failed"
    assert command.reason == "Something is there that is none of the known objects, and it was left there."
    assert near(blocks(portal)["red"], [*EMPTY_PLACE, BLOCK_M / 2])
    assert blocks(portal)["tip"][2] > 0.09


REFUSED = (
    ("pick", (0.8, 0.0), "The arm works from x 320 to 720 mm"),
    ("pick", (-0.3, 0.0), "That place is out of reach. Choose another place."),
    ("pick", (0.56, 0.08), "the open gripper would touch yellow. Choose another place."),
    ("put", (0.5, 0.16), "The gripper holds nothing. Pick something up first."),
)


@hunts(1, 3, 10)
def test_what_cannot_be_done_is_refused_in_words_before_anything_moves(portal):
    portal.grant()
    begun = portal.rig.count("motion")
    for kind, at, why in REFUSED:
        command = act(portal, kind, at)
        assert (command.state, why.lower() in command.reason.lower()) == ("rejected", True), command.reason
    assert portal.rig.count("motion") == begun


@hunts(1, 3, 10)
def test_with_something_in_the_gripper_places_are_refused_before_anything_moves(portal):
    portal.grant()
    done(portal, "pick", FIRST["red"])
    begun = portal.rig.count("motion")
    for kind, at, why in (
        ("pick", FIRST["blue"], "The gripper holds red already. Put it down first."),
        ("put", (0.9, 0.0), "That place is out of reach."),
        ("put", (0.56, 0.085), "yellow is there. Choose another place."),
    ):
        command = act(portal, kind, at)
        assert command.state == "rejected"
        assert why.lower() in command.reason.lower()
    assert portal.rig.count("motion") == begun
    assert beliefs(portal)["red"]["held"]


@hunts(1, 10, 50)
def test_a_stop_in_mid_motion_rests_the_arm_and_the_next_pick_begins_from_there(portal):
    portal.grant()
    command = portal.issue("pick", x=FIRST["red"][0], y=FIRST["red"][1])
    portal.in_motion()
    portal.world.sleep(random.Random(portal.world.seed).random() * 4.0)
    assert portal.stop() < 1.0
    portal.final(command)
    assert command.state == "cancelled"
    begun = portal.rig.count("motion")
    portal.world.sleep(20.0)
    assert portal.rig.count("motion") == begun, "it went on by itself"
    portal.release()
    if not holds_red(portal):
        done(portal, "pick", FIRST["red"])
    done(portal, "put", FIRST["yellow"])
    assert near(blocks(portal)["red"], [*FIRST["yellow"], 1.5 * BLOCK_M])


@hunts(1, 10, 50)
def test_a_connection_that_is_lost_in_mid_motion_rests_the_arm_and_nothing_is_repeated(portal):
    portal.grant()
    command = portal.issue("pick", x=FIRST["red"][0], y=FIRST["red"][1])
    portal.in_motion()
    portal.world.sleep(random.Random(portal.world.seed).random() * 2.0)
    portal.rig.pull()
    command = portal.final(command)
    assert command.state in ("failed", "unknown"), f"{command.state}: {command.reason}"
    portal.at_rest()
    begun = portal.rig.count("motion")
    portal.world.sleep(5.0)
    assert portal.rig.count("motion") == begun
    portal.rig.plug()
    portal.ready_again()
    if not holds_red(portal):
        portal.until(lambda: act(portal, "pick", FIRST["red"]).state == "completed", 60, "the block, picked up")
    done(portal, "put", FIRST["yellow"])
