"""An arm tidies its table in virtual time, judged by the simulator's own positions of its blocks."""

import random

import pytest

from portal.keep.seeding import TIDIES_S
from robots import services
from robots.kit.contract.errors import NotPermitted
from robots.models import Incident, Robot
from robots.states import Cycle, GrantEnd
from tests.world.seeds import hunts
from tests.world.test_picking import BLOCK_M, EMPTY_PLACE, FIRST, move_by_hand
from tests.world.test_tasks import blocks

pytestmark = [pytest.mark.parametrize("which", ["pa10"], indirect=True), pytest.mark.usefixtures("sharp")]
NEAR_M = 0.012  # what such eyes measure, and the arm's own error
OUT_OF_SIGHT = 0.85, -0.55  # on the table
VASE = {"name": "the vase", "low": [0.35, 0.18, 0.0], "high": [0.55, 0.40, 0.3]}  # over an empty place


def in_their_places(portal, *names):
    there = blocks(portal)
    for name in names or FIRST:
        assert there[name] == pytest.approx([*FIRST[name], BLOCK_M / 2], abs=NEAR_M), name


def lay(portal, name, x, y, level=0):
    """Lay a block as somebody beside the table does: on the table, or on so many others."""
    plant = portal.rig.sim.plant
    at = int(plant.model.joint(f"{name}_free").qposadr[0])
    plant.data.qpos[at : at + 3] = x, y, (level + 0.5) * BLOCK_M
    portal.rig.sim._shared.write(plant.qpos)


def scatter(portal):
    """Lay the blocks where a turn may leave them: on each other, at the edge, in each other's places."""
    dice = random.Random(portal.world.seed)
    names = sorted(FIRST)
    dice.shuffle(names)
    a, b, c, d = names
    x, y = FIRST[b]
    lay(portal, a, x, y)  # where b belongs
    lay(portal, b, *(FIRST[a] if dice.random() < 0.5 else (0.44, 0.30)))
    lay(portal, c, 0.64, 0.30)
    lay(portal, d, 0.64, 0.30, level=1)  # a tower at the edge


def tidy(portal, seconds=400.0):
    return portal.final(services.staff_command(portal.row, portal.people["kim"], "tidy"), seconds)


@hunts(3, 10, 50)
def test_staff_have_the_table_tidied(portal):
    portal.ready()
    scatter(portal)
    command = tidy(portal)
    assert (command.state, command.reason) == ("completed", "")
    assert command.progress["text"] == "4 of 4 are in their places"
    in_their_places(portal)
    assert (command.ended_at - command.created_at).total_seconds() < 90
    portal.ready()


@hunts(2, 5, 20)
def test_nobody_but_staff_may_ask_for_it(portal):
    portal.grant()
    with pytest.raises(NotPermitted, match="The command tidy is for staff"):
        portal.issue("tidy")
    with pytest.raises(NotPermitted):
        services.staff_command(portal.row, portal.people["ada"], "tidy")


def tidies_between_turns(portal, seconds=TIDIES_S):
    Robot.objects.filter(pk=portal.robot.pk).update(settings={"tidy_s": seconds})


@hunts(2, 5, 20)
def test_the_next_turn_begins_with_the_blocks_in_their_places(portal):
    tidies_between_turns(portal)
    portal.grant()
    scatter(portal)
    next_turn_after(portal)
    in_their_places(portal)
    assert not Incident.objects.exists()


@hunts(1, 3, 10)
def test_between_turns_the_table_stays_as_it_is_unless_staff_have_set_it(portal):
    portal.grant()
    move_by_hand(portal, "red", *EMPTY_PLACE)
    next_turn_after(portal)
    assert blocks(portal)["red"][:2] == pytest.approx(EMPTY_PLACE, abs=0.001)


def next_turn_after(portal):
    """End the turn and begin the next one; return after how long that could be (s)."""
    at = portal.world.monotonic()
    services.end_grant(services.open_grant(portal.robot), GrantEnd.FINISHED, "over", portal.world.now())
    portal.grant()
    return portal.world.monotonic() - at


@hunts(1, 3, 10)
def test_a_table_that_is_in_order_costs_a_handover_a_few_seconds(portal):
    portal.grant()
    before = next_turn_after(portal)
    tidies_between_turns(portal)
    next_turn_after(portal)  # connected anew, because its settings have changed
    begun = portal.rig.count("motion")
    assert next_turn_after(portal) - before < 6.0
    assert portal.rig.count("motion") > begun


@hunts(1, 3, 10)
def test_a_block_that_is_gone_is_told_and_the_others_are_brought_back(portal):
    portal.ready()
    lay(portal, "red", *OUT_OF_SIGHT)
    lay(portal, "blue", *EMPTY_PLACE)
    command = tidy(portal)
    assert (command.state, command.reason) == (
        "failed", "Red was not brought back: the pictures do not show it. The others are in their places.",
    )  # fmt: skip
    in_their_places(portal, "blue", "yellow", "green")
    portal.ready()


@hunts(1, 3, 10)
def test_a_block_where_the_arm_may_not_go_is_told_and_the_others_are_brought_back(portal):
    Robot.objects.filter(pk=portal.robot.pk).update(settings={"boxes": [VASE]})
    portal.ready()
    lay(portal, "green", *EMPTY_PLACE)
    lay(portal, "blue", 0.45, -0.30)
    command = tidy(portal)
    assert command.state == "failed"
    assert command.reason == (
        "Green was not brought back: there the wrist would enter the vase. The others are in their places."
    )
    in_their_places(portal, "blue", "yellow", "red")
    assert blocks(portal)["green"][:2] == pytest.approx(EMPTY_PLACE, abs=0.001)


@hunts(1, 3, 10)
def test_what_a_turn_has_left_in_the_gripper_is_put_down_first(portal):
    tidies_between_turns(portal)
    portal.grant()
    assert portal.final(portal.issue("pick", x=FIRST["blue"][0], y=FIRST["blue"][1])).state == "completed"
    lay(portal, "red", *FIRST["blue"])
    next_turn_after(portal)
    in_their_places(portal)


@hunts(1, 3, 10)
def test_what_a_handover_has_left_is_one_incident_until_it_is_in_its_place(portal):
    tidies_between_turns(portal)
    portal.ready()
    lay(portal, "red", *OUT_OF_SIGHT)
    portal.grant()
    for _ in range(2):
        next_turn_after(portal)
    told = Incident.objects.get()
    assert told.text == "Red was not brought back: the pictures do not show it. The others are in their places."
    assert (told.code, told.closed_at) == ("untidy", None)
    assert portal.final(portal.issue("ready")).state == "completed", "it can be driven"
    lay(portal, "red", 0.40, 0.30)
    next_turn_after(portal)
    in_their_places(portal)
    told.refresh_from_db()
    assert told.closed_at is not None


@hunts(1, 3, 10)
def test_without_pictures_nothing_is_moved(portal):
    portal.ready()
    scatter(portal)
    before = portal.rig.sim.plant.data.qpos.copy()
    portal.rig.fault("cam_gone")
    command = tidy(portal)
    assert command.state == "failed"
    assert command.reason.startswith("The table was not tidied: the camera")
    assert portal.rig.sim.plant.data.qpos == pytest.approx(before, abs=0.002)


@hunts(1, 3, 10)
def test_with_little_time_it_brings_back_what_it_can(portal):
    tidies_between_turns(portal, 45)
    portal.ready()
    for name, y in zip(FIRST, (0.36, 0.24, -0.24, -0.36), strict=True):
        lay(portal, name, 0.40, y)
    portal.grant()
    next_turn_after(portal)
    told = Incident.objects.get().text
    assert "there was no time left for it." in told
    assert told.endswith("The others are in their places.")


@hunts(3, 10, 50)
def test_a_stop_in_the_middle_rests_the_arm_and_the_next_time_begins_from_there(portal):
    portal.ready()
    scatter(portal)
    command = services.staff_command(portal.row, portal.people["kim"], "tidy")
    portal.in_motion()
    portal.world.sleep(random.Random(portal.world.seed).random() * 40.0)
    assert portal.stop() < 1.0
    portal.final(command)
    if command.state == "completed":
        return  # it had ended before
    assert command.state == "cancelled", command.reason
    begun = portal.rig.count("motion")
    portal.world.sleep(30.0)
    assert portal.rig.count("motion") == begun, "it went on by itself"
    portal.until(lambda: portal.row.stop_latched, 10, "the row of the stop")
    services.release_stop(portal.robot, portal.people["kim"], checked=True)
    portal.until(lambda: not portal.owner.latch.latched, 10, "the release")
    portal.until(lambda: portal.row.cycle == Cycle.READY, 60, "the handover")
    again = tidy(portal)
    assert (again.state, again.reason) == ("completed", "")
    in_their_places(portal)


@hunts(2, 5, 20)
def test_a_stop_while_it_tidies_between_turns_leaves_a_robot_that_is_stopped(portal):
    tidies_between_turns(portal)
    portal.grant()
    scatter(portal)
    services.end_grant(services.open_grant(portal.robot), GrantEnd.FINISHED, "over", portal.world.now())
    Robot.objects.filter(pk=portal.robot.pk).update(cycle=Cycle.HANDOVER)
    portal.in_motion()
    portal.world.sleep(5.0 + random.Random(portal.world.seed).random() * 20.0)
    assert portal.stop() < 1.0
    begun = portal.rig.count("motion")
    portal.until(lambda: portal.row.cycle == Cycle.READY, 180, "a robot whose rest was verified")
    assert portal.rig.count("motion") == begun
