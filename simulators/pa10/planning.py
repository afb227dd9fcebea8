"""The museum arm's planning, in a separate process; see `simulators.common.arm.planning`."""

from collections.abc import Callable

from robots.kit.arms.budget import Budget
from robots.kit.arms.chain import Joints
from robots.kit.arms.zones import Box
from robots.kit.drivers.pa10.courses import Course, Courses
from robots.kit.drivers.pa10.protocol import Request
from simulators.common.arm import planning
from simulators.common.journal import Note


class Planning(planning.Planning, Courses):
    """`Courses` whose slow work is done in the other process."""

    def __init__(self, note: Note = lambda *_, **__: None, forked: bool = False) -> None:
        Courses.__init__(self)
        planning.Planning.__init__(self, Courses, note, forked)

    def forbid(self, extra: tuple[Box, ...]) -> None:
        """Plan around these boxes too."""
        super().forbid(extra)
        self._extra = extra

    def plan(self, request: Request, q: Joints, v: Joints, budget: Budget | None = None) -> Course:
        """See `Courses`; each has the budget of one request."""
        found: Course = self.ask("plan", self._extra, request, q, v)
        return found

    def check(self, steps: list[Request], q: Joints, go_on: Callable[[], None] = lambda: None) -> float:
        """See `Courses`; `go_on` is called at the end, because the budget limits the duration."""
        found: float = self.ask("check", self._extra, steps, q)
        go_on()
        return found
