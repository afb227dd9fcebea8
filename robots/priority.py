"""The priority of processes that may wait."""

import contextlib
import os
from pathlib import Path

AUTOGROUP = Path("/proc/self/autogroup")


def stand_back(by: int) -> None:
    """Make this process nicer by so much (1 to 19), and its session where it leads one.

    Linux shares the processor among sessions first (autogroups), and the supervisor starts each process in a session
    of its own: there the niceness of the process alone changes nothing.
    """
    os.nice(by)
    if os.getsid(0) == os.getpid():
        with contextlib.suppress(OSError):  # no autogroups here
            AUTOGROUP.write_text(str(by))
