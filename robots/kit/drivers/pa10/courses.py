"""Requests on the wire as motions, and checks of whole programs."""

from collections.abc import Callable
from dataclasses import dataclass

from robots.kit.arms.budget import Budget
from robots.kit.arms.chain import Joints
from robots.kit.arms.described import posture
from robots.kit.arms.motions import MotionPlanner
from robots.kit.arms.planner import Plan
from robots.kit.arms.zones import Box
from robots.kit.description import load
from robots.kit.drivers.pa10.protocol import LONGEST_PROGRAM_S, Mode, Request
from robots.kit.drivers.pa10.units import motion_of, step_of

MODES = {"j": Mode.JOINT_CTRL, "k": Mode.KIN_RPY_CTRL, "K": Mode.KIN_EULER_CTRL, "l": Mode.KIN_RPY_CTRL}


@dataclass(frozen=True)
class Course:
    """A motion, and the state register while it runs."""

    mode: Mode
    plan: Plan


def is_default(request: Request) -> bool:
    """Return whether this is the paper's way out of a range error: all joints to zero."""
    return request.letter == "j" and not any(request.numbers[:6])


class Courses(MotionPlanner):
    """Plans the requests of the wire."""

    def __init__(self, extra: tuple[Box, ...] = ()) -> None:
        super().__init__("pa10", LONGEST_PROGRAM_S, extra)
        self.home = posture(load("pa10"), "home")

    def close(self) -> None:
        """Give back what plans need; there is nothing here."""

    def plan(self, request: Request, q: Joints, v: Joints, budget: Budget | None = None) -> Course:
        """Return the motion from the sampled position (rad) and velocity (rad/s). Raises as `plan_motion`."""
        return Course(MODES[request.letter], self.plan_motion(motion_of(request), q, v, budget))

    def check(self, steps: list[Request], q: Joints, go_on: Callable[[], None] = lambda: None) -> float:
        """Check a whole program from rest at `q` and return its duration (s). Raises as `duration`."""
        return self.duration([step_of(step) for step in steps], q, go_on)
