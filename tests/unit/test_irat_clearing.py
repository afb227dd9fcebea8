"""When the iRat's map is cleared: between goals, after 10 to 20 minutes of roaming, never while a goal needs it."""

import pytest
from msgspec import structs

from robots.kit.contract.errors import GaveUp, HardwareFault, MotionHeld
from robots.kit.drivers.irat.brain.messages import Clear, Feed
from robots.kit.drivers.irat.brain.mind import Mind
from tests.irat_trial import NARROW, Trial, begun, free, silent, until


def test_a_goal_that_charging_cuts_short_keeps_the_map_until_it_has_had_its_time(tmp_path):
    trial, goal = begun(tmp_path)
    trial.roaming._clear_s = 10.0
    trial.faults.set("charge", 0.19)
    trial.sleep(1.0)
    with pytest.raises(MotionHeld):  # the need's hold
        trial.roaming.goal(goal, until(trial, 0.5), silent)
    with pytest.raises(MotionHeld):  # staff let it explore
        trial.roaming.explore(until(trial, 5), silent)
    assert trial.brain.mind.slam.map_number == goal["map"]
    trial.faults.set("charge", 0.98)
    trial.roaming.charged()
    trial.sleep(590)
    trial.roaming.clear_if_due()
    assert trial.brain.mind.slam.map_number == goal["map"]
    trial.sleep(20)
    trial.roaming.clear_if_due()
    assert trial.brain.mind.slam.map_number == goal["map"] + 1


@pytest.mark.parametrize(("error", "stays"), [(MotionHeld("Cancelled."), False), (HardwareFault("The radio."), True)])
def test_a_cancelled_goal_does_not_keep_the_map_and_one_with_a_fault_does(tmp_path, error, stays):
    trial, goal = begun(tmp_path)
    trial.roaming._clear_s = 10.0
    times = iter(range(9))

    def permit():
        if next(times) > 4:
            raise error

    with pytest.raises(type(error)):
        trial.roaming.goal(goal, permit, silent)
    trial.sleep(1.0)
    trial.roaming.clear_if_due()
    assert (trial.brain.mind.slam.map_number == goal["map"]) == stays


def test_a_goal_is_reached_although_the_map_cannot_be_cleared_then(tmp_path, monkeypatch):
    trial, goal = begun(tmp_path)
    call, asked = trial.brain.call, []

    def deaf(make, seconds=0.0):
        if isinstance(make(0), Clear):
            asked.append(trial.now)
            raise HardwareFault("The robot's map does not answer.")
        return call(make, seconds)

    monkeypatch.setattr(trial.brain, "call", deaf)
    trial.roaming._latest_s = 10.0
    assert trial.roaming.goal(goal, free, silent)["experience"] == goal["experience"]
    assert asked


def given_up(trial, goal, monkeypatch):
    """Let a goal end because its time is over."""
    call = trial.brain.call
    with monkeypatch.context() as patched:
        patched.setattr(trial.brain, "call", lambda make, *more: structs.replace(call(make, *more), limit_s=0.5))
        with pytest.raises(GaveUp):
            trial.roaming.goal(goal, free, silent)


def test_a_map_ages_while_the_robot_roams_or_rests_and_not_in_its_dock(tmp_path):
    trial = Trial(tmp_path, charge=0.5, width=NARROW)
    trial.sleep(300)
    assert trial.senses.charging
    assert trial.brain.newest.age < 2.0, "it learns nothing there"
    with pytest.raises(MotionHeld):
        trial.roaming.explore(until(trial, 30), silent)
    assert not trial.senses.charging
    left = trial.brain.newest.age
    assert 20 < left <= 31
    trial.sleep(100)
    assert trial.brain.newest.age - left == pytest.approx(100, abs=2)


def test_a_map_ages_by_the_time_between_two_feeds_however_rare_they_are(tmp_path):
    mind = Mind(tmp_path)
    for number in range(101):
        (seen, *_) = mind.take(Feed(1.08 * number, 0.0, 0.0, 1.0))
    assert seen.age == pytest.approx(108, abs=0.1)
    for at in (float("nan"), float("inf"), -5.0, 1e9):
        (seen, *_) = mind.take(Feed(at, 0.0, 0.0, 1.0))
    assert seen.age < 115, "no feed makes it old at once"


@pytest.mark.length
def test_a_slice_of_exploring_clears_a_map_of_ten_minutes_by_itself(tmp_path):
    """With the figures of `robot.toml`, and with nothing but the commands of a day."""
    trial = Trial(tmp_path, width=NARROW)
    numbers, ages = {trial.brain.mind.slam.map_number}, []
    while len(numbers) < 2 and trial.now < 1000:
        ages.append(trial.brain.newest.age)
        trial.roaming.explore(free, silent)
        numbers.add(trial.brain.mind.slam.map_number)
    assert len(numbers) == 2
    assert 600 <= ages[-1] < 665, "at the first slice after ten minutes"
    assert trial.brain.newest.age < 65


def test_a_slice_that_begins_after_a_rest_clears_a_map_that_is_due(tmp_path):
    """At rest the brain is fed once a second, so that its newest answer is hardly ever a fresh one."""
    trial, goal = begun(tmp_path)
    trial.roaming._clear_s = 10.0
    trial.sleep(10)
    while trial.brain.fresh() is not None:
        trial.sleep(0.1)
    with pytest.raises(MotionHeld):
        trial.roaming.explore(until(trial, 1), silent)
    assert trial.brain.mind.slam.map_number == goal["map"] + 1


def test_a_map_is_cleared_once_although_the_brain_told_its_age_before(tmp_path):
    trial, goal = begun(tmp_path)
    trial.roaming._clear_s = 10.0
    for _ in range(2):
        trial.roaming.clear_if_due()
        assert trial.brain.mind.slam.map_number == goal["map"] + 1


def test_after_a_goal_a_map_is_kept_for_those_who_wait_until_its_latest_time(tmp_path):
    trial, goal = begun(tmp_path)
    trial.roaming._clear_s = 10.0
    trial.roaming.goal(goal, free, silent)
    assert trial.brain.mind.slam.map_number == goal["map"], "another goal may wait"
    trial.roaming._latest_s = 20.0
    trial.roaming.goal(goal, free, silent)
    assert trial.brain.mind.slam.map_number == goal["map"] + 1


def test_a_goal_that_ends_without_its_place_clears_a_map_that_is_due_too(tmp_path, monkeypatch):
    trial, goal = begun(tmp_path)
    given_up(trial, goal, monkeypatch)
    assert trial.brain.mind.slam.map_number == goal["map"]
    trial.roaming._latest_s = 10.0
    given_up(trial, goal, monkeypatch)
    assert trial.brain.mind.slam.map_number == goal["map"] + 1


def test_those_who_waited_while_it_charged_are_served_before_the_map_is_cleared(tmp_path, monkeypatch):
    trial, goal = begun(tmp_path)
    trial.roaming._latest_s = 10.0
    trial.roaming.charged()
    for _ in range(3):
        given_up(trial, goal, monkeypatch)
        assert trial.brain.mind.slam.map_number == goal["map"]
    trial.sleep(600)
    given_up(trial, goal, monkeypatch)
    assert trial.brain.mind.slam.map_number == goal["map"] + 1
