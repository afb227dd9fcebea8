"""The brain as a child process of its owner: messages in and out by its pipes."""

import contextlib
import os
import queue
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Protocol

from msgspec import MsgspecError

from robots.kit.clock import TIMER, Timer
from robots.kit.drivers.irat.brain.messages import FromBrain, ToBrain, frame, from_brain, read


class Child(Protocol):
    """A brain that runs apart from its owner; it is made for a folder and begins once."""

    pid: int  # of its process; 0 before it has begun

    def begin(self) -> None:
        """Start it. Raises OSError, RuntimeError where the system has no process or no thread left."""

    def send(self, message: ToBrain) -> None:
        """Send a message, without a wait; it is lost if it cannot be sent."""

    def answers(self) -> Iterator[FromBrain]:
        """Yield its messages, until it has ended."""

    def kill(self) -> None:
        """End it at once."""

    def end(self, seconds: float) -> None:
        """Let it write its map and end, and kill it if that takes longer. Never raises."""


class ChildProcess:
    """``python -m robots.kit.drivers.irat.brain FOLDER``. `real` is the clock by which processes start and end."""

    def __init__(self, folder: Path, real: Timer = TIMER) -> None:
        self._folder, self._real, self.pid = folder, real, 0
        self._process: subprocess.Popen[bytes] | None = None
        self._unsent: queue.SimpleQueue[bytes | None] = queue.SimpleQueue()

    def begin(self) -> None:
        """Start the process, and the thread that writes to it."""
        path = os.pathsep.join(p for p in sys.path if p)
        env = os.environ | {"PYTHONPATH": path, "OMP_NUM_THREADS": "1", "NUMBA_NUM_THREADS": "1"}
        self._process = subprocess.Popen(  # noqa: S603 - our own module
            [sys.executable, "-m", "robots.kit.drivers.irat.brain", str(self._folder)],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=env,
        )  # fmt: skip
        self.pid = self._process.pid
        try:
            self._real.spawn(self._write, "brain-in")
        except RuntimeError:
            self._process.kill()  # nobody would write to it
            raise

    def send(self, message: ToBrain) -> None:
        """Have a message written."""
        self._unsent.put(frame(message))

    def _write(self) -> None:
        """Write the messages, in a thread of its own, because a process that is stuck reads nothing."""
        assert self._process is not None and self._process.stdin is not None
        pipe = self._process.stdin
        with contextlib.suppress(OSError, ValueError):
            while (data := self._unsent.get()) is not None:
                pipe.write(data)
                pipe.flush()
        with contextlib.suppress(OSError, ValueError):
            pipe.close()

    def answers(self) -> Iterator[FromBrain]:
        """Yield its messages, until its pipe has ended or holds an invalid one."""
        if self._process is None or self._process.stdout is None:
            return  # it could not be started
        with contextlib.suppress(OSError, ValueError, MsgspecError):
            while (data := read(self._process.stdout)) is not None:
                yield from_brain.decode(data)

    def kill(self) -> None:
        """Send SIGKILL."""
        if self._process is not None:
            self._process.kill()

    def end(self, seconds: float) -> None:
        """Close its pipe, by which it ends; kill it if that takes longer."""
        process = self._process
        if process is None:
            return
        self._unsent.put(None)
        try:
            process.wait(seconds)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        for pipe in (process.stdin, process.stdout):
            if pipe is not None:
                with contextlib.suppress(OSError, ValueError):
                    pipe.close()
