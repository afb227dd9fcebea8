"""Helper processes of a simulator as forks, started while it has one thread, so that memory is shared."""

import contextlib
import os
import signal
import sys
import traceback
from collections.abc import Callable


class Fork:
    """A forked child with the parts of the interface of `subprocess.Popen` that we need."""

    def __init__(self, pid: int) -> None:
        self.pid = pid
        self.returncode: int | None = None

    def terminate(self) -> None:
        """Send SIGTERM."""
        self._send(signal.SIGTERM)

    def kill(self) -> None:
        """Send SIGKILL."""
        self._send(signal.SIGKILL)

    def wait(self) -> int:
        """Wait for its end; return its exit status."""
        if self.returncode is None:
            self.returncode = os.waitstatus_to_exitcode(os.waitpid(self.pid, 0)[1])
        return self.returncode

    def _send(self, number: int) -> None:
        if self.returncode is None:
            with contextlib.suppress(ProcessLookupError):
                os.kill(self.pid, number)


def fork(work: Callable[[], None]) -> Fork:
    """Run `work` in a fork of this process; the fork ends when `work` does."""
    sys.stdout.flush()
    pid = os.fork()
    if pid:
        return Fork(pid)
    status = 1
    try:
        work()
        status = 0
    except Exception:  # noqa: BLE001 - the fork ends with a traceback, as a process does
        traceback.print_exc()
    finally:
        os._exit(status)
