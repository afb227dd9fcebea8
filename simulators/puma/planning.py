"""The PUMA's planning: in a separate process, and a thread that waits for it, so that the controller never does."""

import threading
from collections.abc import Callable

from robots.kit.arms.chain import Joints
from robots.kit.arms.motions import Motion
from robots.kit.arms.path import Path
from robots.kit.arms.planner import Refused
from robots.kit.arms.zones import Box
from robots.kit.clock import Timer, Until
from simulators.common.arm import planning
from simulators.common.journal import Note
from simulators.puma.courses import Courses

LOOK_S = 3600.0  # between two looks for a question; a new one wakes the thread sooner
Question = Callable[[], Path]


class Planning(planning.Planning, Courses):
    """`Courses` whose slow work is done in the other process."""

    def __init__(self, note: Note, forked: bool = False) -> None:
        Courses.__init__(self)
        planning.Planning.__init__(self, Courses, note, forked)

    def forbid(self, extra: tuple[Box, ...]) -> None:
        """Plan around these boxes too."""
        super().forbid(extra)
        self._extra = extra

    def motion_path(self, motion: Motion, q: Joints) -> Path:
        """See `Courses`."""
        found: Path = self.ask("motion_path", self._extra, motion, q)
        return found

    def index_path(self, q: Joints) -> Path:
        """See `Courses`."""
        found: Path = self.ask("index_path", self._extra, q)
        return found


class PlanningThread:
    """Answers the newest question in a thread of its own; nobody hears the answer to an older one."""

    def __init__(self, clock: Timer) -> None:
        self._clock, self._changed = clock, threading.Condition()
        self._number = 0  # of the newest question
        self._question: Question | None = None
        self._answer: Path | Refused | None = None
        self._open = True

    def begin(self) -> None:
        """Start the thread."""
        self._clock.spawn(self._run, "planning")

    def ask(self, question: Question | None) -> None:
        """Take a new question; None only takes back the one before."""
        with self._changed:
            self._number += 1
            self._question, self._answer = question, None
            self._changed.notify()

    def answer(self) -> Path | Refused | None:
        """Return the answer to the newest question once it is there."""
        return self._answer

    def close(self) -> None:
        """End the thread."""
        with self._changed:
            self._open = False
            self._changed.notify()

    def _run(self) -> None:
        while True:
            with self._changed:
                while not self._clock.wait(Until(self._changed, lambda: self._question or not self._open), LOOK_S):
                    pass
                if not self._open:
                    return
                number, question, self._question = self._number, self._question, None
            assert question is not None
            answer: Path | Refused
            try:
                answer = question()
            except Refused as error:
                answer = error
            with self._changed:
                if number == self._number:
                    self._answer = answer
