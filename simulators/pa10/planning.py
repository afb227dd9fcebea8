"""Planning in a separate process, so that no step of the control loop waits for it.

``python -m simulators.pa10.planning FD`` is that process; it talks over the socket pair whose end it inherits, and ends
with the other end. Each question contains everything on which the answer depends, also the boxes; so a process that is
lost, or does not answer in time, is started again and asked once more.
"""

import os
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Callable
from functools import lru_cache
from multiprocessing.connection import Connection
from typing import Any

from robots.kit.arms.budget import Budget
from robots.kit.arms.chain import Joints
from robots.kit.arms.planner import Refused
from robots.kit.arms.zones import Box
from robots.kit.drivers.pa10.courses import Course, Courses
from robots.kit.drivers.pa10.protocol import Request
from simulators.common.fork import Fork, fork

NICER = 5  # plans may wait; steps of the control loop may not
TRIES = 2
ANSWER_S = 30.0  # only a process that hangs takes so long: work is bounded (`robots/kit/arms/budget.py`)
KEPT = 8  # sets of boxes


class Planning(Courses):
    """`Courses` whose slow work is done in the other process, one question after the other."""

    def __init__(self, note: Callable[..., None] = lambda *_, **__: None, forked: bool = False) -> None:
        """`forked`: start as a fork of this process, which still has one thread; a restarted one is not a fork."""
        super().__init__()
        self._note, self.within_s = note, ANSWER_S
        self._extra: tuple[Box, ...] = ()
        self._asking = threading.Lock()
        self._line, self.process = self._fork() if forked else self._begin()

    @staticmethod
    def _fork() -> tuple[Connection, Fork | subprocess.Popen[bytes]]:
        ours, theirs = socket.socketpair()

        def work() -> None:
            ours.close()
            serve(Connection(theirs.detach()))

        with theirs:
            process = fork(work)
        return Connection(ours.detach()), process

    @staticmethod
    def _begin() -> tuple[Connection, Fork | subprocess.Popen[bytes]]:
        ours, theirs = socket.socketpair()
        with theirs:
            process = subprocess.Popen(  # noqa: S603 - our own program
                [sys.executable, "-m", "simulators.pa10.planning", str(theirs.fileno())],
                pass_fds=[theirs.fileno()],
                env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
            )
        return Connection(ours.detach()), process

    def forbid(self, extra: tuple[Box, ...]) -> None:
        """Plan around these boxes too."""
        super().forbid(extra)
        self._extra = extra

    def plan(self, request: Request, q: Joints, v: Joints, budget: Budget | None = None) -> Course:
        """See `Courses`; each has the budget of one request."""
        found: Course = self._ask("plan", request, q, v)
        return found

    def check(self, steps: list[Request], q: Joints, go_on: Callable[[], None] = lambda: None) -> float:
        """See `Courses`; `go_on` is called at the end, because the budget limits the duration."""
        found: float = self._ask("check", steps, q)
        go_on()
        return found

    def _ask(self, what: str, *about: Any) -> Any:
        """Ask the other process. Raises Refused."""
        with self._asking:
            for _ in range(TRIES):
                try:
                    self._line.send((what, self._extra, about))
                    if not self._line.poll(self.within_s):
                        raise EOFError
                    refused, found = self._line.recv()
                    break
                except (EOFError, OSError):
                    self.close()
                    self._note("planning_lost", code=self.process.returncode)
                    self._line, self.process = self._begin()
            else:
                raise Refused("busy", "the arm's planner was restarted; give the target again")
        if refused:
            raise Refused(*found)
        return found

    def close(self) -> None:
        """End the other process."""
        self._line.close()
        self.process.kill()
        self.process.wait()


@lru_cache(KEPT)
def _courses(extra: tuple[Box, ...]) -> Courses:
    made = Courses()
    made.forbid(extra)
    return made


def answer(what: str, extra: tuple[Box, ...], about: tuple[Any, ...]) -> tuple[bool, Any]:
    """Return whether it is refused, and the answer or code and text of the refusal."""
    try:
        return False, getattr(_courses(extra), what)(*about)
    except Refused as error:
        return True, (error.code, str(error))


def serve(line: Connection) -> None:
    """Answer until the other end is closed."""
    os.nice(NICER)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the asking process ends by it, and this one then
    courses = _courses(())
    home = courses.home
    courses.planner.inverse.nearest(courses.planner.chain.forward(home), home)  # the first call is slow
    while True:
        try:
            line.send(answer(*line.recv()))
        except (EOFError, OSError):
            return


if __name__ == "__main__":
    serve(Connection(int(sys.argv[1])))
