"""Planning in a separate process, so that no step of the control loop waits for it.

``python -m simulators.common.arm.planning FD MODULE CLASS`` is that process. It answers by a `MotionPlanner` of that
class over the socket pair whose end it inherits, and ends with the other end. Each question contains everything on
which the answer depends, also the boxes; so a process that is lost, or does not answer in time, is started again and
asked once more.
"""

import importlib
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

from robots.kit.arms.described import posture
from robots.kit.arms.motions import MotionPlanner
from robots.kit.arms.planner import Refused
from robots.kit.arms.zones import Box
from robots.kit.description import load
from simulators.common.fork import Fork, fork
from simulators.common.journal import Note

NICER = 5  # plans may wait; steps of the control loop may not
TRIES = 2
ANSWER_S = 30.0  # only a process that hangs takes so long: work is bounded (`robots/kit/arms/budget.py`)
KEPT = 8  # sets of boxes
Make = Callable[[], MotionPlanner]


class Planning:
    """Asks the other process, one question after the other.

    `kind`: the class there, a `MotionPlanner` that is made without arguments. `note` hears of a process that was lost.
    `forked`: start as a fork of this process, which still has one thread; a restarted one is not a fork.
    """

    def __init__(self, kind: type[MotionPlanner], note: Note, forked: bool = False) -> None:
        self._kind, self._note, self.within_s = kind, note, ANSWER_S
        self._asking = threading.Lock()
        self._line, self.process = self._fork() if forked else self._begin()

    def _fork(self) -> tuple[Connection, Fork | subprocess.Popen[bytes]]:
        ours, theirs = socket.socketpair()

        def work() -> None:
            ours.close()
            serve(Connection(theirs.detach()), self._kind)  # type: ignore[arg-type]  # see `kind`

        with theirs:
            process = fork(work)
        return Connection(ours.detach()), process

    def _begin(self) -> tuple[Connection, Fork | subprocess.Popen[bytes]]:
        ours, theirs = socket.socketpair()
        kind = self._kind.__module__, self._kind.__qualname__
        with theirs:
            process = subprocess.Popen(  # noqa: S603 - our own program
                [sys.executable, "-m", "simulators.common.arm.planning", str(theirs.fileno()), *kind],
                pass_fds=[theirs.fileno()],
                env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
            )
        return Connection(ours.detach()), process

    def ask(self, what: str, extra: tuple[Box, ...], *about: Any) -> Any:
        """Return what the method `what` returns there, with `extra` boxes beside the arm's own. Raises Refused."""
        with self._asking:
            for _ in range(TRIES):
                try:
                    self._line.send((what, extra, about))
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
def _planner(make: Make, extra: tuple[Box, ...]) -> MotionPlanner:
    made = make()
    made.forbid(extra)
    return made


def answer(make: Make, what: str, extra: tuple[Box, ...], about: tuple[Any, ...]) -> tuple[bool, Any]:
    """Return whether it is refused, and the answer or code and text of the refusal."""
    try:
        return False, getattr(_planner(make, extra), what)(*about)
    except Refused as error:
        return True, (error.code, str(error))


def serve(line: Connection, make: Make) -> None:
    """Answer until the other end is closed."""
    os.nice(NICER)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the asking process ends by it, and this one then
    courses = _planner(make, ())
    home = posture(load(courses.driver), "home")
    courses.planner.inverse.nearest(courses.planner.chain.forward(home), home)  # the first call is slow
    while True:
        try:
            line.send(answer(make, *line.recv()))
        except (EOFError, OSError):
            return


if __name__ == "__main__":
    serve(Connection(int(sys.argv[1])), getattr(importlib.import_module(sys.argv[2]), sys.argv[3]))
