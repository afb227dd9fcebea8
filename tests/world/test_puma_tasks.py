"""Tasks of the PUMA 560 in virtual time, judged by the simulator's own positions of its bricks and its rod."""

import json

import numpy as np
import pytest

from robots.kit.arms.beliefs import How
from robots.kit.arms.goals import goals_of, missing
from robots.kit.arms.objects import objects_of
from robots.kit.description import programs_of
from robots.models import Finding
from robots.services.streams import packets_of
from tests.world.seeds import hunts
from tests.world.test_tasks import begin, beliefs, blocks, run

pytestmark = [pytest.mark.parametrize("which", ["puma"], indirect=True), pytest.mark.usefixtures("sharp")]
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
    assert beliefs(portal)["c"]["how"] == How.MEASURED


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


def figure(portal):
    """Return how far (m, rad) each brick of the figure is from where it belongs, by the simulator."""
    goal = next(one for one in goals_of("puma") if one.name == "figure")
    plant, table = portal.rig.sim.plant, objects_of("puma")
    found = {}
    for name, pose in goal.parts.items():
        body, true = plant.data.body(name), np.eye(4)
        true[:3, :3], true[:3, 3] = body.xmat.reshape(3, 3), body.xpos
        found[name] = missing(table.objects[name], true, pose)
    return found


def told(portal, goal):
    """Return what pages are told of a goal."""
    *_, (data, _) = packets_of(portal.robot, "beliefs")
    return json.loads(data)["goals"][goal]


@hunts(1, 5, 20)
def test_the_figure_of_five_bricks_is_built_by_its_task_and_won_once(portal):
    """Nobody corrects where the bricks are: they are measured."""
    portal.ready()
    assert told(portal, "figure") == {"there": [], "won_ms": None}
    command = run(portal, GALLERY["The figure of five bricks"])
    assert command.reason == ""
    assert (command.state, command.reason) == ("completed", "")
    for name, (metres, angle) in figure(portal).items():
        assert metres < 0.002 and angle < 0.02, f"{name}: {metres * 1000:.2f} mm, {angle:.3f} rad"
    assert portal.rig.sim.plant.clutch.held() >= {("a", "plate"), ("b", "plate"), ("c", "a"), ("c", "b"), ("d", "c")}
    assert sorted(told(portal, "figure")["there"]) == [*"abcde"]
    assert told(portal, "figure")["won_ms"] is not None
    findings = [one.text for one in Finding.objects.filter(command=command)]
    assert findings == ["won: The figure of five bricks"]


@hunts(1, 5, 20)
def test_a_part_that_is_gone_is_missing_again_and_the_rod_is_won_with_its_command(portal):
    command = run(portal, "put a on plate at 2 5\nmove ready")
    assert (command.state, command.reason) == ("completed", "")
    assert told(portal, "figure") == {"there": ["a"], "won_ms": None}
    portal.rig.fault("vanish", 1)
    portal.world.sleep(0.5)
    assert portal.final(portal.issue("task", text="wait 1")).state == "completed"
    assert told(portal, "figure")["there"] == []
    command = portal.final(portal.issue("task", text=GALLERY["The rod, lifted"]), 120)
    assert (command.state, command.reason) == ("completed", "")
    assert told(portal, "rod")["won_ms"] is not None
    assert "won: The rod, lifted from its threads" in [one.text for one in Finding.objects.filter(command=command)]
