"""How the control loop asks the system for its processor in time, with and without the right to real-time priority."""

import ctypes
import os
import platform
import struct

TURN_NS = 400_000  # a little more than one step computes
RESET_ON_FORK = 1  # threads and processes begun later are ordinary ones again
SCHED_SETATTR = {
    "x86_64": 314,
    "aarch64": 274,
}  # the call by its number: few C libraries name it
ATTRIBUTES = struct.Struct("=IIQiIQQQII")  # struct sched_attr of Linux


def first_in_line() -> str:
    """Let the calling thread go before what else wants a processor, as far as the system allows; return how.

    It rests in every step, so that nobody starves.
    """
    try:
        os.sched_setscheduler(0, os.SCHED_RR | os.SCHED_RESET_ON_FORK, os.sched_param(1))
    except (AttributeError, OSError):  # not known here; not allowed to an ordinary user
        return "short turns" if short_turns() else "none"
    return "real time"


def short_turns() -> bool:
    """Ask for short turns: who wants little at once is let in before who wants much (Linux 6.12 on, anybody may)."""
    number = SCHED_SETATTR.get(platform.machine())
    if platform.system() != "Linux" or number is None:
        return False
    nice = os.getpriority(os.PRIO_PROCESS, 0)
    asked = ATTRIBUTES.pack(ATTRIBUTES.size, os.SCHED_OTHER, RESET_ON_FORK, nice, 0, TURN_NS, 0, 0, 0, 0)
    return bool(ctypes.CDLL(None).syscall(number, 0, asked, 0) == 0)
