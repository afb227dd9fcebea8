"""The acts of which a task's step consists: commands of the arm, and where the objects are after each."""

from dataclasses import dataclass, field
from typing import Any

from robots.kit.arms.arrangement import Arrangement
from robots.kit.arms.path import Path
from robots.kit.arms.planner import Refused
from robots.kit.arms.tasks.steps import Step, words

ELSEWHERE = "Choose another place."


@dataclass(frozen=True)
class Act:
    """One command of the arm (`pose`, `line`, a posture, `gripper`), or a `wait` or `expect`, which the runner does.

    `step` is its step, counted from 1 with repetitions expanded. `arrangement`: the objects after it, by the model.
    `seconds`: how long it lasts by its plan. `path`: of the joints, where it moves them.
    """

    step: int
    of: Step
    kind: str
    args: dict[str, Any]
    arrangement: Arrangement
    seconds: float = 0.0
    path: Path | None = field(default=None, repr=False)


class StepImpossible(Refused):
    """A step of a task cannot be done: its number, its line, when it would begin (s), and why."""

    def __init__(self, code: str, step: int, of: Step, at_s: float, why: str) -> None:
        written = words(of.action)
        said = f"Line {of.line}, {written}: {why}." if of.line else f"{why[:1].upper()}{why[1:]}. {ELSEWHERE}"
        super().__init__(code, said)
        self.step, self.line, self.at_s, self.why = step, of.line, at_s, why
