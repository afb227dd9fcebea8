"""The objects and tasks of a driver: the same few lines for every arm with `pose`, `line`, `gripper` and objects.

A driver makes one `ArmTasks`, gives it each state (`observe`), calls `begin` when it has connected, and hands over the
commands whose kinds it has (`KINDS`) to `execute`. Where the gripper tells nothing, it also calls `gripped`. After each
command it calls `report`, which stores with the command what has been won by it. An arm with eyes (`arm_eyes.py`) calls
`look` after each motion at whose end it rests.
"""

import threading
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path

import numpy as np

from robots.kit.arms.beliefs import How, ObjectModel, Snapshot
from robots.kit.arms.chain import Matrix
from robots.kit.arms.described import posture
from robots.kit.arms.goals import goals_of
from robots.kit.arms.hand import Hand
from robots.kit.arms.judging import GoalJudge
from robots.kit.arms.motions import MotionPlanner
from robots.kit.arms.object_streams import ObjectStreams
from robots.kit.arms.objects import objects_of
from robots.kit.arms.tasks import steps
from robots.kit.arms.tasks.requests import AMEND, KINDS, TASK, TIDY, amendment, task_of
from robots.kit.clock import SYSTEM, ms_of
from robots.kit.contract.errors import BadRequest
from robots.kit.contract.find import spec_of
from robots.kit.contract.session import JSON, Observation, OnStage, Outcome, Permit, RobotState, Session
from robots.kit.contract.tidying import LONGEST_S as LONGEST_TIDY_S
from robots.kit.description import load
from robots.kit.drivers.arm_eyes import Sight, eyes_of
from robots.kit.drivers.catching import Catch
from robots.kit.drivers.sights import accept
from robots.kit.drivers.step_judge import StepJudge
from robots.kit.drivers.task_runner import TaskRunner
from robots.kit.drivers.tidying import Tidying

__all__ = ["KINDS", "ArmTasks"]
FILE = "objects.json"


class ArmTasks:
    """`driver` names the robot's folder, `planner` makes its planner, `holds` counts the session's holds."""

    def __init__(
        self, session: Session, driver: str, planner: Callable[[], MotionPlanner], holds: Callable[[], int]
    ) -> None:
        self._session, self._driver, self._planner, self._holds = session, driver, planner, holds
        table, folder = objects_of(driver), session.settings.get("folder")
        self._streams = ObjectStreams(table, lambda name, data, key: session.stream(name, data, key))
        self.hand = Hand(load(driver), spec_of(driver).joints)
        file = Path(folder) / FILE if folder else None
        self._goals = GoalJudge(table, goals_of(driver), _now_ms)
        self._tool_now: Matrix | None = None
        self._judging = threading.Lock()
        self.model = ObjectModel(table, file, _now_ms, self._tell)
        self._eyes = eyes_of(session, driver)
        judge = StepJudge(self.model, self._look_exactly, lambda: self._tool(session.state()))
        self._runner = TaskRunner(session, self.model, self.hand, planner, holds, judge, self._catch)

    def begin(self) -> None:
        """Tell where the objects are; whoever listened to an earlier connection is gone."""
        self._streams.renew()
        self.model.repeat()

    def execute(self, kind: str, args: JSON, permit: Permit, on_stage: OnStage) -> Outcome:
        """Run a command of `KINDS`, whose values were checked. Raises as `Session.execute`."""
        if kind == TIDY:
            self._tidying().run(float(args.get("seconds", LONGEST_TIDY_S)), permit, on_stage)
            return Outcome(dict(args), self._session.latest())
        if kind != AMEND:
            task_for = partial(task_of, self._driver, kind=kind, args=args)
            if kind == TASK:
                task_for(self.model.arrangement)  # a text that is no task is refused at once
            self._runner.run(task_for, permit, on_stage, self.look)
            if self._eyes is not None and self._eyes.is_rough:
                self.look()
            return Outcome(dict(args), self._session.latest())
        permit()
        if self._runner.runs:
            raise BadRequest("A task runs with the objects now; stop it first, or wait until it has ended.")
        self.model.place(*amendment(self.model.table, args), How.STAFF)
        return Outcome(dict(args), self._session.latest())

    def _tidying(self) -> Tidying:
        ready = self._planner().planner.chain.forward(np.array(posture(load(self._driver), "ready")))
        rough = self._eyes is not None and self._eyes.is_rough
        return Tidying(self._session, self.model, self._runner, lambda: self._look(True, {}), self._holds, ready, rough)

    def report(self, on_stage: OnStage) -> None:
        """Store with the command that runs, with a picture, what has been won since the last one."""
        with self._judging:
            news = self._goals.news()
        for goal in news:
            on_stage(Observation(f"won: {goal.title}", photograph=True))

    def _tell(self, now: Snapshot) -> None:
        with self._judging:
            self._goals.look(now, self._tool_now)
            told = self._goals.facts()
        self._streams.tell(now, told)

    def look(self) -> None:
        """Measure the objects in fresh pictures, where the arm rests and has eyes; in a task its own steps look."""
        if not self._runner.runs:
            self._look(False, {})

    def _look(self, insists: bool, or_at: Mapping[str, Matrix]) -> Sight | None:
        """Look as `ArmEyes.look`, and take over what is seen; None where the arm has no eyes, or moves."""
        state = self._session.latest()
        if self._eyes is None or state is None or state.moving:
            return None
        joints = self._planner().planner.chain.joints_in(state.joints)
        sight = self._eyes.look(self.model.arrangement, joints, insists, or_at)
        accept(self.model, sight, self._tool(state), _now_ms())
        return sight

    def _look_exactly(self, insists: bool, or_at: Mapping[str, Matrix]) -> Sight | None:
        """Look where that tells more than the gripper does: rough eyes judge no step, and what was put may be askew."""
        return None if self._eyes is None or self._eyes.is_rough else self._look(insists, or_at)

    def _catch(self, of: steps.Step) -> Catch | None:
        """Return the attempt to take what may swing, None where a step takes nothing of the kind or has no eyes."""
        eyes, name = self._eyes, of.action.name if isinstance(of.action, steps.Grasp) else ""
        described = self.model.table.named(name)
        if eyes is None or described is None or described.threads is None:
            return None
        return Catch(
            self._session.clock, self.model, lambda name: eyes.glance(self.model.arrangement, name), self._planner(),
            of, name,
        )  # fmt: skip

    def observe(self, state: RobotState) -> RobotState:
        """Take over what a gripper that tells its opening says of the model, and return the state.

        That is by hand, or in a program of the arm's own: a task knows what it does.
        """
        if self._goals.lifts(self.model.held):
            self._tool_now = self._tool(state)
            with self._judging:
                changed = self._goals.look(self.model.snapshot, self._tool_now)
            if changed:
                self.model.repeat()
        if self._runner.runs or not self.hand.tells:
            return state
        rests, holds, held = self.hand.rests(state), self.hand.holds(state), self.model.held
        if held is not None and holds is False:
            if self.hand.is_open(state):
                self.model.take(self.model.arrangement.released(self._tool(state)), How.ARM)
            else:
                self.model.place(held, None, How.DROPPED)
        elif held is None and holds and rests:
            self._take(state)
        return state

    def gripped(self, closed: bool, state: RobotState | None) -> None:
        """Take over what a gripper that tells nothing has probably done by a command by hand."""
        if self._runner.runs or state is None:
            return
        if closed and self.model.held is None:
            self._take(state)
        elif not closed:
            self.model.take(self.model.arrangement.released(self._tool(state)), How.ARM)

    def _take(self, state: RobotState) -> None:
        """Let the gripper hold what is between its fingers, by the model."""
        arrangement, tool = self.model.arrangement, self._tool(state)
        name = arrangement.between_fingers(tool)
        if name is not None:
            self.model.take(arrangement.with_held(name, tool), How.ARM)

    def _tool(self, state: RobotState) -> Matrix:
        chain = self._planner().planner.chain
        return chain.forward(chain.joints_in(state.joints))


def _now_ms() -> int:
    return ms_of(SYSTEM.now())
