"""Runs a command only while nothing else wants the processor: `python tools/aside.py COMMAND ARGUMENT...`.

Linux shares the processor among sessions first (autogroups) and then among the processes of each, so the lowest
priority inside the session of somebody else keeps processes of other sessions waiting. The command gets a session of
its own, with the least share. It ends with its parent, because the keys of a terminal do not reach it.
"""

import contextlib
import ctypes
import os
import signal
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from robots.priority import share_less

LEAST = 19
DIE_WITH_PARENT = 1  # PR_SET_PDEATHSIG of Linux


def stand_aside() -> None:
    """Lower this process's priority as far as the system lets it."""
    with contextlib.suppress(OSError):  # it leads a group of processes already, as behind a terminal
        os.setsid()
    share_less(LEAST)
    with contextlib.suppress(AttributeError, OSError):  # not Linux
        ctypes.CDLL(None).prctl(DIE_WITH_PARENT, signal.SIGTERM)
        os.sched_setscheduler(0, os.SCHED_IDLE, os.sched_param(0))
        return
    os.nice(LEAST)


if __name__ == "__main__":
    stand_aside()
    os.execvp(sys.argv[1], sys.argv[1:])  # noqa: S606 - a command of ours, without a shell
