"""Tasks in the session of an arm whose gripper tells nothing, and that moves at once: what the shared driver part does."""

import copy

import numpy as np
import pytest

from robots.kit.arms import objects
from robots.kit.arms.beliefs import How
from robots.kit.arms.commands import motion_of, motion_planner
from robots.kit.arms.described import posture
from robots.kit.arms.pose import numbers
from robots.kit.contract.errors import BadRequest, GaveUp, GrantOver, HardwareFault, MotionHeld, OutOfWorkspace
from robots.kit.contract.session import Outcome, Progress, RobotState, Session
from robots.kit.description import load
from robots.kit.drivers import arm_tasks
from robots.kit.drivers.arm_eyes import Sight
from robots.kit.drivers.arm_tasks import ArmTasks
from robots.kit.drivers.sights import accept

TOWER = "put red on yellow\nput blue on red\nexpect blue on red"


class QuickArm(Session):
    """An arm with the museum arm's kinematics that is where it is told at once. `fails`: by act, counted from 1."""

    def __init__(self, settings=None, fails=None):
        super().__init__("", settings or {})
        self.planner = motion_planner("pa10", 300.0, {})
        self.q, self.holds, self.acts, self.fails = np.array(posture(load("pa10"), "ready")), 0, [], fails or {}
        self.sent = []
        self.on_packet = lambda name, data, key: self.sent.append((name, data, key))
        self.tasks = ArmTasks(self, "pa10", lambda: self.planner, lambda: self.holds)

    def connect(self):
        self.tasks.begin()
        return self.state()

    def state(self):
        pose = numbers(self.planner.planner.chain.forward(self.q))
        state = RobotState(self.clock.monotonic(), tuple(self.q), pose, False, True)
        return self.tasks.observe(self.keep(state))

    def execute(self, kind, args, permit, on_stage):
        if kind in arm_tasks.KINDS:
            return self.tasks.execute(kind, args, permit, on_stage)
        self.acts.append(kind)
        permit()
        on_stage("sent")
        if fails := self.fails.get(len(self.acts)):
            fails() if callable(fails) and not isinstance(fails, type) else None
            if isinstance(fails, Exception):
                raise fails
        on_stage("acknowledged")
        if kind != "gripper":
            motion = motion_of("pa10", kind, args)
            self.q = self.planner.plan_motion(motion, self.q, np.zeros(6)).target
            permit()
        elif not self.tasks.hand.tells:
            self.tasks.gripped(args["closed"] >= 0.5, self.state())
        return Outcome(dict(args), self.state())

    def hold(self):
        self.holds += 1
        return self.state()

    def close(self):
        pass


@pytest.fixture(autouse=True)
def without_knowledge(monkeypatch):
    """A gripper that tells nothing, as a pneumatic one, and no eyes."""
    monkeypatch.setattr(arm_tasks, "eyes_of", lambda *_: None)
    told = copy.deepcopy(load("pa10"))
    del told["gripper"]["joint"]
    monkeypatch.setattr(arm_tasks, "load", lambda driver: told)


def allow():
    pass


def run(arm, text, permit=allow):
    stages = []
    try:
        outcome = arm.execute("task", {"text": text}, permit, stages.append)
    except Exception as error:
        return error, stages
    return outcome, stages


def beneath(arm, name):
    return arm.tasks.model.arrangement.beneath(name)


def test_a_task_is_one_command_whose_steps_are_told_after_it_has_begun():
    arm = QuickArm()
    arm.connect()
    outcome, stages = run(arm, TOWER)
    assert outcome.sent == {"text": TOWER}
    assert stages[:2] == ["sent", "acknowledged"]
    assert all(isinstance(one, Progress) for one in stages[2:])
    texts = list(dict.fromkeys(one.text for one in stages[2:]))
    assert texts == [
        "line 1 of 3: put red on yellow", "line 2 of 3: put blue on red", "line 3 of 3: expect blue on red",
    ]  # fmt: skip
    shares = [one.share for one in stages[2:]]
    assert shares == sorted(shares)
    assert 0.0 <= shares[0] < shares[-1] <= 1.0
    assert (beneath(arm, "red"), beneath(arm, "blue")) == (("yellow",), ("red",))
    assert arm.holds == 0


def test_waits_and_expectations_alone_have_begun_too():
    arm = QuickArm()
    outcome, stages = run(arm, "expect empty\nwait 0.1\nexpect red on table")
    assert isinstance(outcome, Outcome)
    assert stages[:2] == ["sent", "acknowledged"]
    assert arm.acts == []


def test_what_a_permit_raises_comes_out_as_it_is_and_nothing_follows():
    for allowed in range(0, 15, 2):
        arm, counted, over = QuickArm(), [0], GrantOver("over")

        def permit(counted=counted, allowed=allowed, over=over):
            counted[0] += 1
            if counted[0] > allowed:
                raise over

        error, stages = run(arm, "put red on yellow", permit)
        assert error is over
        assert (stages == []) is (allowed == 0)
        acts = list(arm.acts)
        assert len(acts) <= allowed + 1
        assert not arm.tasks._runner.runs


def test_a_hold_between_two_acts_ends_the_task_for_good():
    arm = QuickArm(fails={3: lambda: None})
    arm.fails[3] = arm.hold
    error, _ = run(arm, TOWER)
    assert isinstance(error, MotionHeld)
    assert len(arm.acts) == 3
    assert isinstance(run(arm, "put red on yellow")[0], Outcome), "a new task begins from where it is"


@pytest.mark.parametrize("refusal", [OutOfWorkspace("There is a box."), BadRequest("Nobody knows it.")])
def test_a_refused_step_holds_the_arm_and_names_line_and_cause(refusal):
    arm = QuickArm(fails={12: refusal})
    error, _ = run(arm, TOWER)
    assert isinstance(error, GaveUp)
    cause = str(refusal)[:1].lower() + str(refusal)[1:-1]
    assert str(error) == f"Line 2 of 3, put blue on red: {cause}. The arm was held."
    assert arm.holds == 1
    assert len(arm.acts) == 12
    assert beneath(arm, "red") == ("yellow",)


def test_a_fault_of_the_hardware_stays_one_and_holds_the_arm():
    fault = HardwareFault("The line is cut.")
    arm = QuickArm(fails={5: fault})
    assert run(arm, TOWER)[0] is fault
    assert arm.holds == 1


@pytest.mark.parametrize(
    ("text", "error", "says"),
    [
        ("lift red", BadRequest, "Line 1: 'lift' is no step"),
        ("grasp red\ngrasp blue", OutOfWorkspace, "Line 2, grasp blue: the gripper holds red already."),
    ],
)
def test_what_cannot_be_done_is_refused_before_anything_moves(text, error, says):
    arm = QuickArm()
    found, stages = run(arm, text)
    assert isinstance(found, error)
    assert says in str(found)
    assert (arm.acts, stages, arm.holds) == ([], [], 0)


def test_single_commands_are_believed_where_the_gripper_tells_nothing(tmp_path):
    arm = QuickArm({"folder": str(tmp_path)})
    down = {"x": 0.5, "y": 0.16, "roll": np.pi, "pitch": 0.0, "yaw": np.pi}
    for kind, args in (("pose", {**down, "z": 0.12}), ("line", {**down, "z": 0.022}), ("gripper", {"closed": 1.0})):
        arm.execute(kind, args, allow, lambda _: None)
    assert arm.tasks.model.held == "red"
    again = QuickArm({"folder": str(tmp_path)})
    assert again.tasks.model.held == "red", "another owner knows what the arm holds"
    again.q = arm.q
    assert isinstance(run(again, "put red at 450 250")[0], Outcome)
    assert again.tasks.model.belief("red").how == How.ARM
    assert again.tasks.model.arrangement.places["red"].place == pytest.approx((0.45, 0.25, 0.02), abs=1e-6)


def test_what_was_measured_is_used_and_what_was_dropped_is_not():
    arm = QuickArm()
    pose = objects.pose_of(arm.tasks.model.table.first()["red"])
    pose[:3, 3] = 0.42, -0.3, 0.02
    accept(arm.tasks.model, Sight({"red": pose}, frozenset({"red"})), arm.planner.planner.chain.forward(arm.q), 0)
    assert arm.tasks.model.belief("red").how == How.MEASURED
    assert isinstance(run(arm, "grasp red\nmove 450 0 250")[0], Outcome)
    arm.execute("gripper", {"closed": 0.0}, allow, lambda _: None)
    assert arm.tasks.model.belief("red").how == How.DROPPED
    assert "where red lies is not known" in str(run(arm, "grasp red")[0])
