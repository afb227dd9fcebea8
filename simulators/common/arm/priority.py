"""Gives the control loop the processor when it needs it, with or without the right to real-time priority."""

import ctypes
import os
import platform
import struct

TURN_NS = 400_000  # a little more than one step computes
RESET_ON_FORK = 1  # threads and processes started later are ordinary ones
SCHED_SETATTR = {"x86_64": 314, "aarch64": 274}  # the number of the system call, which few C libraries name
ATTRIBUTES = struct.Struct("=IIQiIQQQII")  # struct sched_attr of Linux


def first_in_line() -> str:
    """Run the calling thread before others, as far as the system allows; return by which means.

    It sleeps in every step, so no other process starves.
    """
    try:
        os.sched_setscheduler(0, os.SCHED_RR | os.SCHED_RESET_ON_FORK, os.sched_param(1))
    except (AttributeError, OSError):  # not available; not allowed for ordinary users
        return "short turns" if short_turns() else "none"
    return "real time"


def short_turns() -> bool:
    """Ask for short time slices: threads that need little at once run sooner (Linux 6.12 on, for everybody)."""
    number = SCHED_SETATTR.get(platform.machine())
    if platform.system() != "Linux" or number is None:
        return False
    nice = os.getpriority(os.PRIO_PROCESS, 0)
    asked = ATTRIBUTES.pack(ATTRIBUTES.size, os.SCHED_OTHER, RESET_ON_FORK, nice, 0, TURN_NS, 0, 0, 0, 0)
    return bool(ctypes.CDLL(None).syscall(number, 0, asked, 0) == 0)
