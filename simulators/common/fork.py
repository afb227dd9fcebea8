"""Helpers of a simulator as forks of it, begun while it has one thread: they share what it has loaded."""

import os
import signal
import sys
import traceback
from collections.abc import Callable


class Fork:
    """A forked child, with what we need of `subprocess.Popen`."""

    def __init__(self, pid: int) -> None:
        self.pid = pid
        self.returncode: int | None = None

    def terminate(self) -> None:
        """Ask it to end."""
        self._send(signal.SIGTERM)

    def kill(self) -> None:
        """End it."""
        self._send(signal.SIGKILL)

    def wait(self) -> int:
        """Wait for its end; return its exit status."""
        if self.returncode is None:
            self.returncode = os.waitstatus_to_exitcode(os.waitpid(self.pid, 0)[1])
        return self.returncode

    def _send(self, number: int) -> None:
        if self.returncode is None:
            os.kill(self.pid, number)


def fork(work: Callable[[], None]) -> Fork:
    """Run `work` in a fork of this process, which ends with it."""
    sys.stdout.flush()
    pid = os.fork()
    if pid:
        return Fork(pid)
    status = 1
    try:
        work()
        status = 0
    except Exception:  # noqa: BLE001 - told where a process tells it
        traceback.print_exc()
    finally:
        os._exit(status)
