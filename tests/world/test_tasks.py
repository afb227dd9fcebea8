"""Tasks of the museum arm in virtual time, judged by the simulator's own positions of its blocks."""

import json
import random

import numpy as np
import pytest

from robots import services
from robots.kit.arms.beliefs import How
from robots.kit.arms.objects import objects_of
from robots.kit.arms.tasks.requests import arrangement_of
from robots.kit.contract.errors import BadRequest
from robots.models import Command
from robots.services.streams import packets_of
from tests.world.seeds import hunts

pytestmark = pytest.mark.parametrize("which", ["pa10"], indirect=True)
TOWER = "# three blocks\ngrasp red\nput red on yellow\ngrasp blue\nput blue on red\nexpect blue on red"
NEAR_M = 0.004


def blocks(portal):
    """Return where the simulated blocks are (m)."""
    return portal.rig.sim.status()["objects"]


def beliefs(portal):
    """Return what the arm's driver keeps of the objects, by name."""
    return json.loads((portal.rig.folder / "objects.json").read_bytes())


def shown(portal):
    """Return where a page sees the objects, by the packets of the stream."""
    table = objects_of("pa10")
    return arrangement_of(table, packets_of(portal.robot, "objects")).places


def begin(portal, text):
    portal.grant()
    return portal.issue("task", text=text)


def run(portal, text):
    return portal.final(begin(portal, text), 120)


def near(one, other):
    return list(one) == pytest.approx(other, abs=NEAR_M)


@hunts(1, 5, 20)
def test_a_tower_of_three_stands_at_the_end_of_its_task(portal):
    command = run(portal, TOWER)
    assert (command.state, command.reason) == ("completed", "")
    assert Command.objects.filter(kind="task").count() == 1
    there = blocks(portal)
    assert near(there["red"], [*there["yellow"][:2], 0.06])
    assert near(there["blue"], [*there["yellow"][:2], 0.10])
    for name in ("red", "blue", "yellow"):
        assert near(beliefs(portal)[name]["place"], there[name]), name
        assert near(list(shown(portal)[name].place), there[name]), name
    assert beliefs(portal)["red"]["how"] == How.ARM
    assert beliefs(portal)["green"]["how"] == How.START
    assert command.progress["text"] == "line 6 of 6: expect blue on red"


def at_line(portal, command, line):
    """Wait until the task is at a line."""

    def reached():
        command.refresh_from_db()
        return command.progress.get("text", "").startswith(f"line {line} of")

    portal.until(reached, 60, f"line {line}")


@hunts(1, 10, 50)
def test_a_stop_in_mid_task_rests_the_arm_and_nothing_goes_on(portal):
    command = begin(portal, TOWER)
    at_line(portal, command, 3)
    portal.world.sleep(random.Random(portal.world.seed).random() * 2.0)
    assert portal.stop() < 1.0
    portal.final(command)
    assert command.state == "cancelled"
    assert "line 3 of 6" in command.reason
    begun = portal.rig.count("motion")
    portal.world.sleep(20.0)
    assert portal.rig.count("motion") == begun, "it went on by itself"
    portal.release()
    assert blocks(portal)["blue"] == pytest.approx([0.5, -0.08, 0.02], abs=NEAR_M)
    load = [name for name, one in beliefs(portal).items() if one["held"]]
    again = portal.final(portal.issue("task", text="put red at 450 250\nexpect red on table"), 120)
    assert (again.state, again.reason) == ("completed", "")
    assert load in ([], ["red"])
    assert near(blocks(portal)["red"], [0.45, 0.25, 0.02])


@hunts(1, 5, 20)
def test_a_gripper_that_gives_way_ends_the_task_and_names_the_line(portal):
    """The block's place is not known then, until somebody has looked."""
    command = begin(portal, "grasp red\nput red at 450 250\nmove ready")
    at_line(portal, command, 2)
    portal.rig.fault("slip")
    portal.final(command)
    assert (command.state, command.reason) == (
        "failed",
        "Line 2 of 3, put red at 450 250: the gripper is empty: it has lost red. The arm was held.",
    )
    assert not portal.rig.moving
    portal.rig.clear_faults()
    assert beliefs(portal)["red"]["how"] == How.DROPPED
    assert "red" not in shown(portal)
    refused = portal.final(portal.issue("task", text="move ready\ngrasp red"))
    assert (refused.state, refused.reason) == ("rejected", "Line 2, grasp red: where red lies is not known.")
    portal.world.sleep(5.0)
    x, y, z = blocks(portal)["red"]  # as somebody sees it who looks
    amended = services.configure(
        portal.row, portal.people["kim"], "amend", {"object": 0, "x": x, "y": y, "z": z, "yaw": 0.0}
    )
    assert portal.final(amended).state == "completed"
    assert beliefs(portal)["red"]["how"] == How.STAFF
    portal.until(lambda: "red" in shown(portal), 5, "the place on pages")
    assert shown(portal)["red"].place == pytest.approx((x, y, z), abs=1e-4)


@hunts(1, 5, 20)
def test_staff_change_no_place_while_a_task_runs_with_it(portal):
    command = begin(portal, TOWER)
    at_line(portal, command, 2)
    there = {"object": 1, "x": 0.4, "y": 0.3, "z": 0.02, "yaw": 0.0}
    refused = portal.final(services.configure(portal.row, portal.people["kim"], "amend", there))
    assert (refused.state, refused.reason[:12]) == ("rejected", "A task runs ")
    with pytest.raises(BadRequest, match="z must lie between"):
        services.configure(portal.row, portal.people["kim"], "amend", {**there, "z": 9.0})
    assert portal.final(command, 120).state == "completed"
    assert near(blocks(portal)["blue"], [0.56, 0.05, 0.10])


@hunts(1, 5, 20)
def test_a_block_that_is_not_there_ends_the_task(portal):
    """Somebody took it away: the fingers close on nothing."""
    plant = portal.rig.sim.plant
    at = int(plant.model.joint("red_free").qposadr[0])
    plant.data.qpos[at] = 0.65
    command = run(portal, "grasp red\nput red on yellow")
    assert command.state == "failed"
    assert command.reason == "Line 1 of 2, grasp red: the gripper is empty: red was not there. The arm was held."
    assert beliefs(portal)["red"]["how"] == How.MISSED


@hunts(1, 5, 20)
def test_what_the_arm_has_done_outlives_its_owner(portal):
    assert run(portal, "put red on yellow").state == "completed"
    portal.supervisor.worker.kill()
    portal.ready_again()
    again = portal.final(portal.issue("task", text="expect red on yellow\ngrasp yellow"))
    assert (again.state, again.reason) == ("rejected", "Line 2, grasp yellow: red lies on yellow.")
    assert portal.final(portal.issue("task", text="put red at 500 160"), 120).state == "completed"


@hunts(1, 5, 20)
def test_a_block_that_is_carried_by_hand_is_followed(portal):
    """Single commands, and the arm's own programs, change the model as tasks do; carrying sends no packets."""
    program = "\n".join(
        ("g 0", "k 500 160 150 180 0 180", "l 500 160 22 180 0 180", "g 1", "l 500 160 150 180 0 180",
         "k 450 250 150 180 0 180", "l 450 250 23 180 0 180")
    )  # fmt: skip
    portal.grant()
    assert portal.final(portal.issue("program", text=program), 120).state == "completed"
    assert shown(portal)["red"].held
    packets = len(packets_of(portal.robot, "objects"))
    down = {"x": 0.45, "y": 0.25, "roll": np.pi, "pitch": 0.0, "yaw": np.pi}
    assert portal.final(portal.issue("line", z=0.12, **down)).state == "completed"
    assert portal.final(portal.issue("line", z=0.023, **down)).state == "completed"
    assert len(packets_of(portal.robot, "objects")) == packets
    assert portal.final(portal.issue("gripper", closed=0.0)).state == "completed"
    portal.world.sleep(1.0)
    assert near(list(shown(portal)["red"].place), blocks(portal)["red"])
    assert near(blocks(portal)["red"], [0.45, 0.25, 0.02])


@hunts(1, 5, 20)
def test_a_file_of_places_that_is_torn_gives_the_first_places_and_says_so(portal):
    assert run(portal, "put red on yellow").state == "completed"
    (portal.rig.folder / "objects.json").write_bytes(b'{"red": {"how": "placed by')
    portal.supervisor.worker.kill()
    portal.ready_again()
    portal.until(lambda: "could not be read" in said(portal)["note"], 30, "what is said of the file")
    assert said(portal)["objects"]["red"]["how"] == How.START


def said(portal):
    packets = packets_of(portal.robot, "beliefs")
    return json.loads(packets[-1][0]) if packets else {"note": ""}
