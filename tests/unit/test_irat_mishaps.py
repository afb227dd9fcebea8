"""Faults in the middle of the iRat's motions, on a clock of its own: each is reported at rest, or is overcome."""

import pytest

from robots.kit.contract.errors import CameraFault, GaveUp, HardwareFault
from robots.kit.drivers.irat.brain.messages import Feed
from robots.kit.drivers.irat.brain.mind import SAVE_S, Mind
from robots.kit.drivers.irat.spec import Mode
from robots.kit.drivers.irat.wheels import BLIND_S, SILENT_S
from tests.conftest import FakeClock
from tests.irat_trial import NARROW, Trial, begun, explore, free, silent

HOURS_S = 2 * 3600.0  # a battery lasts so long at rest
AS_WELL = (("explore", "cam_black"), ("goal", "cam_gone"), ("explore", "cam_freeze"))


def test_blocked_wheels_in_a_goal_are_told_as_stuck_and_it_is_given_up(tmp_path):
    trial, goal = begun(tmp_path)
    modes = set()

    def permit():
        trial.faults.set("stall")
        modes.add(trial.senses.state().mode)

    with pytest.raises(GaveUp, match="was not reached within"):
        trial.roaming.goal(goal, permit, silent)
    assert {Mode.GOAL, Mode.STUCK} <= modes
    assert not trial.world.drive.moving
    assert trial.senses.state().mode == Mode.RESTING
    trial.faults.clear()
    assert trial.roaming.goal(goal, free, silent)["experience"] == goal["experience"]


@pytest.mark.parametrize(
    ("kind", "fault"),
    [
        ("goal", "cam_black"),
        ("explore", "cam_gone"),
        ("goal", "cam_freeze"),
        *(pytest.param(*pair, marks=pytest.mark.length) for pair in AS_WELL),
    ],
)
def test_a_motion_whose_camera_is_of_no_use_for_long_ends_at_rest(tmp_path, kind, fault):
    trial, goal = begun(tmp_path)
    began, known = trial.now, trial.brain.mind.slam.map.count

    def blind():
        trial.faults.set(fault)
        trial.faults.set("stall")  # it must not arrive before

    run = {
        "explore": lambda: trial.roaming.explore(blind, silent),
        "goal": lambda: trial.roaming.goal(goal, blind, silent),
    }
    with pytest.raises(CameraFault, match="No picture of the robot's camera is of use"):
        run[kind]()
    assert BLIND_S <= trial.now - began < BLIND_S + 3
    assert not trial.world.drive.moving
    assert trial.brain.mind.slam.map.count <= known + 2, "it taught nothing"


def test_a_goal_cut_by_a_radio_that_is_silent_for_hours_goes_on_afterwards(tmp_path):
    trial, goal = begun(tmp_path)
    cut_at = trial.now + 1.0

    def permit():
        if trial.now >= cut_at:
            trial.faults.set("awol")

    with pytest.raises(HardwareFault):
        trial.roaming.goal(goal, permit, silent)
    assert trial.now - cut_at < SILENT_S + 2
    trial.sleep(1.0)
    assert not trial.world.drive.moving, "a velocity that is not said again is forgotten"
    stood = trial.world.plant.pose
    trial.world.tick(HOURS_S)  # at rest: in one step
    trial.now += HOURS_S
    assert trial.world.plant.pose == pytest.approx(stood, abs=1e-3), "nothing moves it meanwhile"
    trial.faults.clear()
    trial.sleep(2.0)
    done = trial.roaming.goal(goal, free, silent)
    assert (done["map"], done["experience"]) == (goal["map"], goal["experience"])


@pytest.mark.length
def test_where_no_dock_is_seen_it_goes_to_another_remembered_place(tmp_path):
    """False markers made it remember places from where there is no dock."""
    trial = Trial(tmp_path, width=NARROW)
    explore(trial, 100)
    slam, told = trial.brain.mind.slam, []
    true = set(slam.docks.places)
    assert true
    false = [int(slam.map.ids[slam.map.count - n]) for n in (12, 6)]
    assert not true & set(false)
    for experience in false:
        for _ in range(9):
            slam.docks.saw(experience, 0.2, 0.0)
    assert slam.docks.best() in false
    trial.faults.set("charge", 0.19)
    trial.sleep(1.0)

    def permit():
        if trial.world.charging:
            trial.faults.set("charge", 0.98)

    trial.charging.charge(permit, told.append)
    assert trial.world.charging
    assert [getattr(said, "text", "") for said in told].count("going to a place from where the dock was seen") >= 2
    assert slam.docks.best() not in false


def test_the_map_is_saved_every_ten_seconds(tmp_path):
    clock = FakeClock()
    mind, times, began = Mind(tmp_path, clock), [], clock.monotonic()
    kept = (tmp_path / "kept").read_text()
    for number in range(450):
        clock.go(0.1)
        list(mind.take(Feed(0.1 * number, 0.0, 0.0, 0.1)))
        if (now := (tmp_path / "kept").read_text()) != kept:
            kept = now
            times.append(clock.monotonic() - began)
    assert times == pytest.approx([SAVE_S * n for n in (1, 2, 3, 4)], abs=0.6)
    assert SAVE_S == 10.0
