"""Minutes and hours of the iRat in its maze, on a clock of its own."""

import math
from dataclasses import dataclass

import numpy as np
import pytest

from robots.kit.contract.errors import GaveUp, HardwareFault, MotionHeld
from robots.kit.drivers.irat.brain.messages import Care, Clear, Forget
from robots.kit.drivers.irat.brain.places import MapCleared
from robots.kit.drivers.irat.spec import Mode
from robots.kit.slam.routes import index_of
from robots.kit.slam.storage import load
from simulators.irat.maze import DOCK
from tests.irat_trial import NARROW, Trial, begun, explore, explored, free, place, silent, until


@dataclass(frozen=True)
class Old:
    """A topic that has fallen silent."""

    value: object
    at: float


def before_dock(far, aside=0.0):
    """Return the pose so far (m) before the dock, and so far (m) beside its axis, that looks at it."""
    x, y, out = DOCK
    return (
        x + far * math.cos(out) - aside * math.sin(out), y + far * math.sin(out) + aside * math.cos(out), out + math.pi,
    )  # fmt: skip


def error_of(trial):
    """Return the root mean square (m) by which the map differs from where its places are, turned and shifted alike."""
    held = trial.brain.mind.slam.map
    ids = [i for i in held.ids[: held.count].tolist() if i in trial.truth]
    mapped = np.array([held.poses[index_of(held, i), :2] for i in ids])
    true = np.array([trial.truth[i][:2] for i in ids])
    mapped, true = mapped - mapped.mean(0), true - true.mean(0)
    u, _, vt = np.linalg.svd(mapped.T @ true)
    turned = mapped @ u @ np.diag([1.0, np.sign(np.linalg.det(u @ vt))]) @ vt
    return float(np.sqrt(((turned - true) ** 2).sum(1).mean()))


def test_it_docks_charges_and_leaves_backwards(tmp_path):
    trial = Trial(tmp_path, pose=before_dock(0.5), charge=0.19)
    told = []
    with pytest.raises(MotionHeld):
        trial.charging.charge(until(trial, 90), told.append)
    assert trial.world.charging
    assert trial.line.charger.value > 0
    assert any("docking, try 1" in getattr(said, "text", "") for said in told)
    trial.faults.set("charge", 0.98)
    trial.sleep(1.0)
    with pytest.raises(MotionHeld):
        trial.roaming.explore(until(trial, 8), silent)
    assert not trial.world.charging
    assert trial.world.plant.pose[1] < DOCK[1] - 0.1


@pytest.mark.length
def test_bent_contacts_are_told_after_twelve_tries(tmp_path):
    trial = Trial(tmp_path, pose=before_dock(0.5), charge=0.19, width=NARROW)
    trial.faults.set("contacts_bent")
    told = []
    with pytest.raises(GaveUp, match="12 tries; its contacts may be bent"):
        trial.charging.charge(until(trial, 1800), told.append)
    assert not trial.world.drive.moving
    assert trial.notes["charging"] == 0
    tries = {said.text for said in told if "docking" in getattr(said, "text", "")}
    assert len(tries) >= 3
    trial.faults.clear()  # staff bent them straight
    with pytest.raises(MotionHeld):
        trial.charging.charge(until(trial, 400), silent)
    assert trial.world.charging


@pytest.mark.length
@pytest.mark.parametrize(("seed", "pruning"), [(1, False), (2, True)], ids=["cleared", "pruned"])
def test_it_maps_its_maze_closes_loops_and_reaches_places(tmp_path, seed, pruning):
    trial = Trial(tmp_path, seed=seed, width=NARROW)
    trial.brain.call(lambda number: Care(number, pruning))
    explore(trial, 420)
    slam = trial.brain.mind.slam
    assert slam.map.count > 300
    assert slam.map.linked > slam.map.count + 5, "links beside those from each place to the next: loops"
    assert error_of(trial) < 0.25
    assert (slam.map.count < slam.map.next_id / 2) == pruning
    for number in (slam.map.count // 4, slam.map.count // 2):
        goal = int(slam.map.ids[number])
        trial.roaming.goal(place(trial, goal), free, silent)
        assert math.dist(trial.truth[goal][:2], trial.world.plant.pose[:2]) < 0.4
        assert not trial.world.drive.moving


@pytest.mark.length
@pytest.mark.parametrize(
    ("fault", "value"), [("slip", 0.6), ("ir_dead", 0b010), ("false_marker", 7), ("carried", 11), ("stall", 1)]
)
def test_a_goal_under_a_fault_ends_with_a_word_and_at_rest(tmp_path, fault, value):
    trial = Trial(tmp_path, seed=3, width=NARROW)
    explore(trial, 180)
    ids = trial.brain.mind.slam.map.ids[20:].tolist()
    goal = next(i for i in ids if math.dist(trial.truth[i][:2], DOCK[:2]) > 0.6)  # goals at the dock are refused
    trial.faults.set(fault, value)
    began = trial.now
    try:
        trial.roaming.goal(place(trial, goal), free, silent)
        reached = True
    except GaveUp as error:
        reached = False
        assert "was not reached within" in str(error)
    assert not trial.world.drive.moving
    assert trial.notes["passed"] == 0
    seen = trial.brain.newest
    assert trial.now - began < 400
    if reached:
        held = trial.brain.mind.slam.map
        assert math.dist(seen.pose[:2], held.poses[index_of(held, goal), :2]) < 0.15, "its own map says so"


def test_a_brain_that_was_started_again_is_told_the_goal_again(tmp_path):
    """The place that is lost with its last seconds is found by where it was."""
    trial, goal = begun(tmp_path)
    slam, lost = trial.brain.mind.slam, goal["experience"]
    saved_at = trial.now + 1.0

    def permit():
        if trial.now > saved_at and lost in slam.map.ids:
            slam.map.ids[: slam.map.count] += 1000  # the same places, and none of their old numbers
            slam.skip_ids()
            trial.brain.post(Forget())

    assert trial.roaming.goal(goal, permit, silent)["map"] == goal["map"]
    held = slam.map
    assert math.dist(held.pose()[:2], held.poses[index_of(held, lost + 1000), :2]) < 0.15


def test_a_battery_that_falls_silent_is_a_fault_and_its_last_word_is_not_believed(tmp_path):
    trial, goal = begun(tmp_path)
    trial.line.battery = Old(trial.line.battery.value, trial.now)
    trial.sleep(9.0)
    assert trial.senses.state().values["charge"] == pytest.approx(100, abs=2)
    with pytest.raises(HardwareFault, match="does not tell how much charge"):
        trial.roaming.goal(goal, free, silent)
    assert not trial.world.drive.moving
    assert not {"charge", "battery"} & trial.senses.state().values.keys()


def test_at_critical_charge_a_goal_ends_at_rest_with_the_map_saved(tmp_path):
    trial, goal = begun(tmp_path)
    path = tmp_path / "map.npz"
    path.unlink(missing_ok=True)

    def permit():
        trial.faults.set("charge", 0.07)

    with pytest.raises(HardwareFault, match="almost flat"):
        trial.roaming.goal(goal, permit, silent)
    assert not trial.world.drive.moving
    assert load(path, trial.brain.mind.slam.settings).map.count == trial.brain.mind.slam.map.count
    assert trial.senses.state().mode == Mode.FLAT


def test_a_map_that_is_cleared_on_the_way_ends_the_goal(tmp_path):
    trial = explored(tmp_path)
    slam = trial.brain.mind.slam
    places = slam.map.poses[:, :2]
    # far from where it is, so that it is on its way when the map is cleared
    far = np.hypot(*(places - places[slam.map.current]).T)
    far[np.hypot(*(places - places[0]).T) < 0.5] = 0.0  # at the dock no goal may lie
    goal, end = place(trial, int(slam.map.ids[int(np.argmax(far))])), trial.now + 0.5

    def permit():
        if trial.now > end and slam.map_number == goal["map"]:
            trial.brain.call(Clear)

    with pytest.raises(MapCleared, match="cleared on the way"):
        trial.roaming.goal(goal, permit, silent)
    assert not trial.world.drive.moving
    with pytest.raises(MapCleared):
        trial.roaming.goal(goal, free, silent)
