"""Tidying in the session of an arm that moves at once and sees what it is told: what is tried, and what ends it."""

import pytest

from robots.kit.arms.objects import pose_of
from robots.kit.contract.errors import ControllerRefused, GaveUp, GrantOver, HardwareFault, MotionHeld
from robots.kit.contract.session import Outcome, Progress
from robots.kit.drivers.arm_eyes import Sight
from tests.drivers.test_arm_tasks import QuickArm, allow, without_knowledge  # noqa: F401 - a fixture
from tests.unit.test_tidying import BLOCKS, stood


class Eyes:
    """Notices what is believed to lie about, but for what is `hidden`; `looks` are called one a look."""

    is_rough = True

    def __init__(self, arm):
        self.arm, self.hidden, self.looks, self.blind = arm, set(), [], ""

    def look(self, arrangement, q, insists=False, or_at=None):
        if self.looks:
            self.looks.pop(0)()
        return Sight(noticed=frozenset(set(arrangement.places) - self.hidden), blind=self.blind)


@pytest.fixture
def arm():
    """An arm beside which red lies at a free place, and blue on yellow."""
    made = QuickArm()
    made.tasks._eyes = Eyes(made)
    made.connect()
    model = made.tasks.model
    places = dict(model.arrangement.places) | {"red": stood(BLOCKS, "red", 0.44, 0.30)}
    places["blue"] = stood(BLOCKS, "blue", *places["yellow"].place[:2], "yellow", 0.0, places)
    model.place_all({name: places[name] for name in ("red", "blue")}, "measured")
    return made


def tidy(arm, permit=allow, **args):
    stages = []
    try:
        return arm.execute("tidy", args, permit, stages.append), stages
    except Exception as error:
        return error, stages


def at_first(arm, name):
    place = arm.tasks.model.arrangement.places[name].place
    return place == pytest.approx(BLOCKS.objects[name].first.place, abs=0.002)


def test_it_is_one_command_that_tells_how_far_it_is(arm):
    outcome, stages = tidy(arm)
    assert isinstance(outcome, Outcome)
    assert stages[:2] == ["sent", "acknowledged"]
    assert all(isinstance(one, Progress) for one in stages[2:])
    assert [one.text for one in stages[2:]] == [f"{n} of 4 are in their places" for n in (2, 3, 4)]
    assert [one.share for one in stages[2:]] == [0.5, 0.75, 1.0]
    assert all(at_first(arm, name) for name in BLOCKS.objects)


def test_what_the_pictures_do_not_show_is_not_moved(arm):
    arm.tasks._eyes.hidden = {"red"}
    error, _ = tidy(arm)
    assert isinstance(error, GaveUp)
    assert str(error) == "Red was not brought back: the pictures do not show it. The others are in their places."
    assert arm.tasks.model.arrangement.places["red"].place[:2] == (0.44, 0.30)
    assert at_first(arm, "blue")


def test_without_pictures_nothing_is_gripped(arm):
    arm.tasks._eyes.blind = "the camera table gives no picture"
    error, _ = tidy(arm)
    assert str(error) == "The table was not tidied: the camera table gives no picture."
    assert "gripper" not in arm.acts


def test_an_arm_without_eyes_says_so(arm):
    arm.tasks._eyes = None
    error, _ = tidy(arm)
    assert str(error) == "The table was not tidied: this arm has no cameras that show it objects."


def test_what_fails_twice_is_left_with_its_cause_and_the_others_are_brought_back(arm):
    """A stop is none of these: it ends all."""
    model, told = arm.tasks.model, arm.execute

    def refusing(kind, args, permit, on_stage):
        if kind == "gripper" and args["closed"] and tool_is_over("red"):
            raise ControllerRefused("The gripper has no air.")
        return told(kind, args, permit, on_stage)

    def tool_is_over(name):
        tool = arm.planner.planner.chain.forward(arm.q)[:2, 3]
        return tool == pytest.approx(pose_of(model.arrangement.places[name])[:2, 3], abs=0.01)

    arm.execute = refusing
    error, _ = tidy(arm)
    assert str(error) == "Red was not brought back: the gripper has no air. The others are in their places."
    assert arm.holds == 2, "it was tried twice"
    assert at_first(arm, "blue")


def test_a_hold_between_two_moves_ends_it_for_good(arm):
    arm.tasks._eyes.looks = [lambda: None, arm.hold]
    error, _ = tidy(arm)
    assert isinstance(error, MotionHeld)
    done = len(arm.acts)
    assert done > 0
    assert not (at_first(arm, "red") and at_first(arm, "blue"))


def test_what_a_permit_raises_comes_out_as_it_is_and_nothing_follows(arm):
    refusal = GrantOver("The turn is over.")

    def denied():
        raise refusal

    error, stages = tidy(arm, denied)
    assert (error, stages, arm.acts) == (refusal, [], [])


def test_a_fault_of_the_hardware_stays_one(arm):
    arm.fails = {3: HardwareFault("It does not answer.")}
    error, _ = tidy(arm)
    assert isinstance(error, HardwareFault)
    assert len(arm.acts) == 3


def test_a_move_for_which_there_is_no_time_is_not_begun(arm):
    error, _ = tidy(arm, seconds=10.0)
    assert str(error) == (
        "Red was not brought back: there was no time left for it."
        " Blue was not brought back: there was no time left for it. The others are in their places."
    )
    assert "gripper" not in arm.acts
