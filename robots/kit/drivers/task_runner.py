"""Runs a task inside a driver's session: each act through the session's own `execute`, under the permit of the task.

So a hold, a stop, a lost link and the end of the grant act as on any other motion. Nothing goes on by itself.
"""

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from itertools import groupby
from operator import attrgetter

import numpy as np

from robots.kit.arms.arrangement import Arrangement, NotPossible
from robots.kit.arms.beliefs import How, ObjectModel
from robots.kit.arms.chain import Joints
from robots.kit.arms.hand import Hand
from robots.kit.arms.motions import MotionPlanner
from robots.kit.arms.objects import placed_of
from robots.kit.arms.tasks import steps
from robots.kit.arms.tasks.acts import Act, StepImpossible
from robots.kit.arms.tasks.planning import plan
from robots.kit.arms.tasks.steps import Step, Task, words
from robots.kit.contract.errors import (
    BadRequest,
    ControllerRefused,
    GaveUp,
    HardwareFault,
    OutOfWorkspace,
    RobotError,
)
from robots.kit.contract.session import Observation, OnStage, Permit, Progress, RobotState, Session
from robots.kit.drivers.catching import Catch
from robots.kit.drivers.permits import until_held
from robots.kit.drivers.step_judge import StepJudge

LOOK_S = 0.05  # between two looks while it waits
UNKNOWN_LOAD = "The gripper holds something that is none of the known objects; open it first."


class GripLost(GaveUp):
    """The gripper does not hold what it should."""


class TaskRunner:
    """Runs one task at a time. `holds` counts the session's holds: one of them ends a task for good.

    `judge` looks at what each step has done; `catching` returns the attempt to take an object that may swing.
    """

    def __init__(
        self, session: Session, model: ObjectModel, hand: Hand, planner: Callable[[], MotionPlanner],
        holds: Callable[[], int], judge: StepJudge, catching: Callable[[Step], Catch | None],
    ) -> None:  # fmt: skip
        self._session, self._model, self._hand, self._judge = session, model, hand, judge
        self._planner, self._holds, self._catching = planner, holds, catching
        self._load: str | None = None  # the object that the gripper has to hold now
        self.runs = False

    def run(
        self, task_for: Callable[[Arrangement], Task], permit: Permit, on_stage: OnStage, look: Callable[[], None]
    ) -> None:
        """Run a task to its end; where it cannot go on, hold the arm. `look` measures the objects before it is planned.

        `task_for` returns the task, with the objects as they are known then.

        Raises:
            BadRequest, OutOfWorkspace: it is no task, or it cannot be done; nothing has moved.
            GaveUp: a step was refused, or the gripper is empty; with its line and the cause.
            And what `Session.execute` raises.
        """
        state = self._at_rest(permit)
        free = until_held(permit, self._holds)  # from before it is planned, which takes a moment
        look()
        self.runs = True  # from now on nobody else changes where the objects are
        try:
            task = task_for(self._model.arrangement)
            self._run(task, self._planned(task, state), free, _Stages(on_stage))
        finally:
            self.runs = False

    def _run(self, task: Task, acts: list[Act], free: Permit, stages: "_Stages") -> None:
        self._load = self._model.held
        done, total = 0.0, sum(act.seconds for act in acts) or 1.0
        self._judge.begin()
        for number, (_, group) in enumerate(groupby(acts, key=attrgetter("step"))):
            of_step = list(group)
            line, written = of_step[0].of.line, words(of_step[0].of.action)
            stages.tell(Progress(f"line {line} of {task.lines}: {written}" if line else written, done / total))
            self._step(f"line {line} of {task.lines}, {written}" if line else "", of_step, number > 0, free, stages)
            done += sum(act.seconds for act in of_step)
        stages.begin()

    def _step(self, name: str, acts: list[Act], begun: bool, free: Permit, stages: "_Stages") -> None:
        """Carry out the acts of one step; an arm that has seen more since they were planned plans them again.

        `name` says which step it is, empty for one that comes from no text.
        """
        of, first = acts[0].of, self._model.arrangement
        carries = isinstance(of.action, steps.Grasp | steps.PutOn | steps.PutAt)
        waiting, closed = deque(acts), False
        with self._named(name, begun):
            if begun and self._judge.sees and carries:
                waiting = self._again(of)
            if (catch := self._swinging(of, free, stages)) is not None:
                waiting = deque(catch.approach)
        while waiting or catch is not None:
            with self._named(name, begun):
                if catch is not None and not waiting:
                    waiting, catch = deque(catch.last(self._joints(), free)), None
                act = waiting.popleft()
                self._carry_out(act, free, stages, [] if name else waiting)
                lifted, closed = closed and carries, act.kind == "gripper" and bool(act.args["closed"])
                if lifted and self._judge.lifted(act, first, stages.note) and waiting:
                    waiting = self._again(of)  # how it is held is known better now
            begun = True
        with self._named(name, begun):
            self._judge.after(act, stages.note)

    def _again(self, of: Step) -> deque[Act]:
        """Return the acts of a step from where arm and objects are now. Raises NotPossible."""
        try:
            return deque(plan(self._planner(), Task((of,)), self._model.arrangement, self._joints()))
        except StepImpossible as error:
            raise NotPossible(error.why) from error

    def _joints(self) -> Joints:
        return self._planner().planner.chain.joints_in(self._session.state().joints)

    def _swinging(self, of: Step, permit: Permit, stages: "_Stages") -> Catch | None:
        """Return the attempt to take what swings, once it has been watched; None where nothing swings."""
        catch = self._catching(of)
        if catch is None:
            return None
        permit()
        stages.begin()
        swing = catch.watch(permit)
        if swing is None:
            return None
        catch.begin(swing, self._joints())
        return catch

    def _at_rest(self, permit: Permit) -> RobotState:
        state = self._session.state()
        if state.moving:  # a task begins at rest
            permit()
            state = self._session.hold()
        return state

    def _planned(self, task: Task, state: RobotState) -> list[Act]:
        """Return the acts of the task from here. Raises OutOfWorkspace."""
        planner, arrangement = self._planner(), self._model.arrangement
        first = next(task.steps()).action
        if self._hand.holds(state) and arrangement.held is None and first != steps.Open():
            raise OutOfWorkspace(UNKNOWN_LOAD)
        try:
            return plan(planner, task, arrangement, planner.planner.chain.joints_in(state.joints))
        except StepImpossible as error:
            raise OutOfWorkspace(str(error)) from error

    @contextmanager
    def _named(self, name: str, begun: bool) -> Iterator[None]:
        """Hold the arm where an act fails, and name the step and the cause."""
        try:
            yield
        except (BadRequest, OutOfWorkspace, ControllerRefused, GaveUp, NotPossible) as error:
            if not begun and isinstance(error, BadRequest | OutOfWorkspace | ControllerRefused):
                raise  # nothing has moved
            with suppress(RobotError):  # what cannot be held is found by the owner's own looks
                self._session.hold()
            cause = str(error).rstrip(".")
            if not name:
                raise GaveUp(f"{cause[:1].upper()}{cause[1:]}.") from error
            raise GaveUp(f"{name[:1].upper()}{name[1:]}: {cause[:1].lower()}{cause[1:]}. The arm was held.") from error
        except HardwareFault:
            with suppress(RobotError):
                self._session.hold()
            raise

    def _carry_out(self, act: Act, free: Permit, stages: "_Stages", leaves: Iterable[Act] = ()) -> None:
        """Carry out one act. `leaves`: those by which the arm goes away where its gripper has taken nothing."""

        def permit() -> None:
            free()
            self._check_grip(self._session.latest())

        if act.kind in ("wait", "expect"):
            permit()
            stages.begin()
            self._look_on(act, permit, stages)
        elif act.kind == "gripper":
            try:
                self._grip(act, free, stages)
            except GripLost:
                for one in leaves if act.args["closed"] else ():
                    self._session.execute(one.kind, one.args, free, stages.pass_on)
                raise
        else:
            self._session.execute(act.kind, act.args, permit, stages.pass_on)
            self._check_grip(self._session.latest())

    def _look_on(self, act: Act, permit: Permit, stages: "_Stages") -> None:
        """Wait, or compare what is expected with pictures, with the model and with what the gripper tells."""
        clock = self._session.clock
        until = clock.monotonic() + act.args.get("seconds", 0.0)
        while (left := until - clock.monotonic()) > 0:
            clock.sleep(min(LOOK_S, left))
            self._session.state()
            permit()
        if act.kind == "expect":
            action = act.of.action
            self._judge.expected(action, stages.note)
            if action == steps.ExpectHeld(None) and self._hand.holds(self._session.state()):
                raise NotPossible("the gripper holds something")

    def _grip(self, act: Act, free: Permit, stages: "_Stages") -> None:
        closes, load = bool(act.args["closed"]), act.arrangement.held
        self._load = None
        self._session.execute(act.kind, act.args, free, stages.pass_on)
        state = self._session.state()
        if closes and isinstance(act.of.action, steps.Feel):
            self._felt(state, free, stages)
            return
        if closes and load is not None and self._hand.holds(state) is False:
            self._model.place(load, None, How.MISSED)
            raise GripLost(f"The gripper is empty: {load} was not there")
        if not closes and self._hand.holds(state):
            raise GripLost("The gripper does not open")
        self._model.take(act.arrangement, How.ARM)
        self._load = load

    def _felt(self, state: RobotState, free: Permit, stages: "_Stages") -> None:
        """Judge what the gripper has closed on where nothing was known to lie. Raises GripLost."""
        if not self._hand.holds(state):
            raise GripLost("The gripper is empty: nothing was there")
        lost = [one for name, one in self._model.table.objects.items() if self._model.belief(name).place is None]
        if len(lost) != 1:
            self._session.execute("gripper", {"closed": 0.0}, free, stages.pass_on)
            raise GripLost("Something is there that is none of the known objects, and it was left there")
        (found,) = lost
        held = placed_of(np.asarray(np.linalg.inv(found.grasps[0].tool)), held=True)
        self._model.place(found.name, held, How.ARM)
        self._load = found.name

    def _check_grip(self, state: RobotState | None) -> None:
        """Notice an object that was lost on the way. Raises GripLost."""
        load = self._load
        if load is not None and self._hand.holds(state) is False:
            self._load = None
            self._model.place(load, None, How.DROPPED)
            raise GripLost(f"The gripper is empty: it has lost {load}")


class _Stages:
    """Passes on the first stages of a task's acts alone, and its progress after them: a task is one command."""

    def __init__(self, on_stage: OnStage) -> None:
        self._on_stage, self._begun = on_stage, False
        self._progress: Progress | None = None

    def tell(self, progress: Progress) -> None:
        """Tell how far the task is, once it has begun."""
        if self._begun:
            self._on_stage(progress)
        else:
            self._progress = progress

    def note(self, text: str) -> None:
        """Tell a result of the task on its way, in words."""
        self.begin()
        self._on_stage(Observation(text))

    def pass_on(self, stage: object) -> None:
        """Take a stage of an act, and what was observed in it."""
        if isinstance(stage, Observation):
            self._on_stage(stage)
        if self._begun or stage not in ("sent", "acknowledged"):
            return
        assert isinstance(stage, str)
        self._on_stage(stage)
        if stage == "acknowledged":
            self._begun = True
            if self._progress is not None:
                self._on_stage(self._progress)

    def begin(self) -> None:
        """Tell that it has begun, where no act of the arm has."""
        if not self._begun:
            self.pass_on("sent")
            self.pass_on("acknowledged")
