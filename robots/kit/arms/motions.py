"""Motions as people and programs ask for them: planned for one arm, with the limits of its `robot.toml`."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from robots.kit.arms.budget import MOST, Budget, TooMuch
from robots.kit.arms.chain import Joints
from robots.kit.arms.described import boxes, planner
from robots.kit.arms.inverse import OutOfReach
from robots.kit.arms.path import Path, TooFast, joint_path
from robots.kit.arms.planner import Plan, Refused
from robots.kit.arms.pose import RPY, Six, matrix
from robots.kit.arms.straight import line_path
from robots.kit.arms.zones import Box
from robots.kit.description import load


@dataclass(frozen=True)
class Motion:
    """A motion to `joints` (rad), or to a `pose` of the tool (m and rad, by the convention `angles`).

    `straight`: on a straight line of the tool. `scale`: the share of full speed, None for the one of `robot.toml`.
    """

    joints: tuple[float, ...] = ()
    pose: Six | None = None
    angles: str = RPY
    straight: bool = False
    scale: float | None = None


@dataclass(frozen=True)
class Pause:
    """A step of a program during which the arm rests for so long (s)."""

    seconds: float


Step = Motion | Pause


class StepRefused(Refused):
    """A step of a program is not planned: which one, counted from 1, when it would begin (s), and why."""

    def __init__(self, code: str, step: int, at_s: float, why: str) -> None:
        super().__init__(code, f"step {step}, after {at_s:.1f} s: {why}")
        self.step, self.at_s, self.why = step, at_s, why


def refuse_long(seconds: float, longest_s: float) -> None:
    """Refuse a motion that takes longer than one may. Raises Refused."""
    if seconds > longest_s:
        raise Refused(
            "range",
            f"the motion would take {seconds:.0f} s, longer than the {longest_s:g} s that one may take; "
            "ask for more of full speed, or go less far",
        )


class MotionPlanner:
    """Plans motions and programs of the arm that the files of `driver` describe, among its forbidden boxes.

    `longest_program_s`: how long a program may last. `extra`: forbidden boxes beside the arm's own (m).
    """

    def __init__(self, driver: str, longest_program_s: float, extra: tuple[Box, ...] = ()) -> None:
        self.driver = driver
        self._longest_program_s = longest_program_s
        motion = load(driver)["motion"]
        self._scale, self._scales = float(motion["scale"]), motion["scale_range"]
        self._longest_s = float(motion["limit_s"])
        self.forbid(extra)

    def forbid(self, extra: tuple[Box, ...]) -> None:
        """Plan around these boxes too, beside the arm's own."""
        self.planner = planner(self.driver, boxes(load(self.driver)) + extra)

    def _share(self, motion: Motion) -> float:
        """Return the requested share of full speed, or the default. Raises Refused."""
        if motion.scale is None:
            return self._scale
        low, high = self._scales
        if not low <= motion.scale <= high:
            raise Refused("range", f"the share of full speed must lie between {low:g} and {high:g}")
        return motion.scale

    def plan_motion(self, motion: Motion, q: Joints, v: Joints, budget: Budget | None = None) -> Plan:
        """Return the plan from the sampled position (rad) and velocity (rad/s), checked against the boxes.

        Raises:
            Refused: names the joint, the distance or the limb and box, or says that it would last or take too long
            to plan.
        """
        scale, planner = self._share(motion), self.planner
        budget = Budget(MOST) if budget is None else budget
        if motion.pose is None:
            plan = planner.joints(np.array(motion.joints), q, v, scale, budget)
        elif motion.straight:
            plan = planner.line(matrix(motion.pose, motion.angles), q, v, scale, budget)
        else:
            target = planner.reach(matrix(motion.pose, motion.angles), q, budget)
            plan = planner.joints(target, q, v, scale, budget)
        refuse_long(plan.path.seconds, self._longest_s)
        return plan

    def expected(self, motion: Motion, q: Joints, v: Joints) -> Path | None:
        """Return the path of a motion that a controller with this planner has accepted; None if there is none.

        It is not checked against the boxes again: the controller has done so.
        """
        arm = self.planner
        try:
            if motion.straight and motion.pose is not None:
                end = matrix(motion.pose, motion.angles)
                return line_path(arm.inverse, q, end, arm.limits, self._share(motion), Budget(MOST))
            target = (
                np.array(motion.joints) if motion.pose is None else arm.reach(matrix(motion.pose, motion.angles), q)
            )
            return joint_path(q, v, target, arm.limits, self._share(motion))
        except (Refused, TooFast, TooMuch, OutOfReach):
            return None

    def along(self, steps: Iterable[Step], q: Joints) -> Iterator[tuple[int, float, Path | None]]:
        """Yield each step of a program from rest at `q`: its number, its duration (s), its path if it moves.

        Raises:
            StepRefused: a step cannot be planned, or the program would last too long.
        """
        here, total, budget = q, 0.0, Budget(MOST)
        plans: dict[tuple[Step, bytes], Plan] = {}  # repeated steps are planned once
        for number, step in enumerate(steps, 1):
            begins = total
            try:
                if isinstance(step, Pause):
                    seconds, path = step.seconds, None
                else:
                    key = step, here.tobytes()
                    if key not in plans:
                        plans[key] = self.plan_motion(step, here, np.zeros_like(here), budget)
                    here, path = plans[key].target, plans[key].path
                    seconds = path.seconds
                total += seconds
                if total > self._longest_program_s:
                    raise Refused(
                        "range",
                        f"the program would take longer than the {self._longest_program_s:g} s that one may take; "
                        "make two of it",
                    )
            except Refused as error:
                raise StepRefused(error.code, number, begins, str(error)) from error
            yield number, seconds, path

    def duration(self, steps: Iterable[Step], q: Joints, go_on: Callable[[], None] = lambda: None) -> float:
        """Check a whole program from rest at `q` and return its duration (s). Calls `go_on` after each step.

        Raises:
            StepRefused, and whatever `go_on` raises.
        """
        total = 0.0
        for _, seconds, _ in self.along(steps, q):
            go_on()
            total += seconds
        return total
