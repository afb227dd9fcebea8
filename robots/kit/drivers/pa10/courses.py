"""Requests on the wire as motions, and checks of whole programs."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from robots.kit.arms.budget import MOST, Budget
from robots.kit.arms.chain import Joints
from robots.kit.arms.described import boxes, planner, posture
from robots.kit.arms.path import Path
from robots.kit.arms.planner import Plan, Refused
from robots.kit.arms.zones import Box
from robots.kit.description import load
from robots.kit.drivers.pa10.forms import LONGEST_WAIT_S
from robots.kit.drivers.pa10.limits import LONGEST_PROGRAM_S
from robots.kit.drivers.pa10.protocol import MOTIONS, Mode, Request
from robots.kit.drivers.pa10.units import pose_of

MODES = {"j": Mode.JOINT_CTRL, "k": Mode.KIN_RPY_CTRL, "K": Mode.KIN_EULER_CTRL, "l": Mode.KIN_RPY_CTRL}


@dataclass(frozen=True)
class Course:
    """A motion, and the state register while it runs."""

    mode: Mode
    plan: Plan


class StepRefused(Refused):
    """A step of a program is not planned: which one, counted from 1, when it would begin (s), and why."""

    def __init__(self, code: str, step: int, at_s: float, why: str) -> None:
        super().__init__(code, f"step {step}, after {at_s:.1f} s: {why}")
        self.step, self.at_s, self.why = step, at_s, why


def is_default(request: Request) -> bool:
    """Return whether this is the paper's way out of a range error: all joints to zero."""
    return request.letter == "j" and not any(request.numbers[:6])


class Courses:
    """Plans the requests of the wire."""

    def __init__(self, extra: tuple[Box, ...] = ()) -> None:
        description = load("pa10")
        self._own = boxes(description)
        self.planner = planner("pa10", self._own + extra)
        motion = description["motion"]
        self._scale, self._scales = float(motion["scale"]), motion["scale_range"]
        self._longest_s = float(motion["limit_s"])
        self.home = posture(description, "home")

    def close(self) -> None:
        """Give back what plans need; there is nothing here."""

    def forbid(self, extra: tuple[Box, ...]) -> None:
        """Plan around these boxes too, beside the arm's own."""
        self.planner = planner("pa10", self._own + extra)

    def scale(self, request: Request) -> float:
        """Return the requested share of full speed, or the default."""
        if len(request.numbers) < 7:
            return self._scale
        low, high = self._scales
        if not low <= request.numbers[6] <= high:
            raise Refused("range", f"the share of full speed must lie between {low:g} and {high:g}")
        return request.numbers[6]

    def plan(self, request: Request, q: Joints, v: Joints, budget: Budget | None = None) -> Course:
        """Return the motion from the sampled position (rad) and velocity (rad/s), checked against the boxes.

        Raises:
            Refused: names the joint, the distance or the limb and box, or says that it would last or take too long
            to plan.
        """
        scale, planner = self.scale(request), self.planner
        budget = Budget(MOST) if budget is None else budget
        if request.letter == "j":
            made = planner.joints(np.radians(request.numbers[:6]), q, v, scale, budget)
        elif request.letter == "l":
            made = planner.line(pose_of(request), q, v, scale, budget)
        else:
            made = planner.joints(planner.reach(pose_of(request), q, budget), q, v, scale, budget)
        if made.path.seconds > self._longest_s:
            raise Refused(
                "range",
                f"the motion would take {made.path.seconds:.0f} s, longer than the {self._longest_s:g} s that one may "
                "take; ask for more of full speed, or go less far",
            )
        return Course(MODES[request.letter], made)

    def along(self, steps: list[Request], q: Joints) -> Iterator[tuple[int, Path]]:
        """Yield the motions of a program from rest at `q`, each with the number of its step.

        Waiting and moving times are added up on the way. Raises StepRefused.
        """
        here, seconds, budget = q, 0.0, Budget(MOST)
        known: dict[tuple[Request, bytes], Plan] = {}  # repeated steps are planned once
        for number, step in enumerate(steps, 1):
            begins = seconds
            try:
                seconds += self.pause(step)
                if step.letter in MOTIONS:
                    key = step, here.tobytes()
                    if key not in known:
                        known[key] = self.plan(step, here, np.zeros_like(here), budget).plan
                    here = known[key].target
                    seconds += known[key].path.seconds
                if seconds > LONGEST_PROGRAM_S:
                    raise Refused(
                        "range",
                        f"the program would take longer than the {LONGEST_PROGRAM_S:g} s that one may take; "
                        "make two of it",
                    )
            except Refused as error:
                raise StepRefused(error.code, number, begins, str(error)) from error
            if step.letter in MOTIONS:
                yield number, known[key].path

    def check(self, steps: list[Request], q: Joints, go_on: Callable[[], None] = lambda: None) -> float:
        """Check a whole program from rest at `q` and return its duration (s). Calls `go_on` between steps.

        Raises:
            StepRefused, and whatever `go_on` raises.
        """
        seconds = 0.0
        for _, path in self.along(steps, q):
            go_on()
            seconds += path.seconds
        return seconds + self.pauses(steps)

    @staticmethod
    def pauses(steps: list[Request]) -> float:
        """Return the time for which a program waits and grips (s). Raises Refused."""
        return sum(Courses.pause(step) for step in steps)

    @staticmethod
    def pause(step: Request) -> float:
        """Return the time for which a step waits or grips (s). Raises Refused."""
        if step.letter == "d":
            if not 0 <= step.numbers[0] <= LONGEST_WAIT_S:
                raise Refused("range", f"a wait lasts 0 to {LONGEST_WAIT_S} s")
            return step.numbers[0]
        if step.letter == "g":
            if step.numbers[0] not in (0.0, 1.0):
                raise Refused("range", "the gripper knows 0 (open) and 1 (close)")
            return 1.0
        return 0.0
