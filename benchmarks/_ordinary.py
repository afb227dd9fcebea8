"""Run a command without the right to real-time priority: ``python -m benchmarks._ordinary COMMAND ...``."""

import contextlib
import ctypes
import os
import resource
import sys

PR_CAPBSET_DROP, CAP_SYS_NICE = 24, 23  # of Linux


def main() -> None:
    """Give up the right for good and become the command."""
    with contextlib.suppress(AttributeError):  # a limit of Linux alone
        resource.setrlimit(resource.RLIMIT_RTPRIO, (0, 0))
    if sys.platform == "linux":
        # root has the right by this capability; others may not drop it, and do not have it either
        ctypes.CDLL(None).prctl(PR_CAPBSET_DROP, CAP_SYS_NICE, 0, 0, 0)
    os.execvp(sys.argv[1], sys.argv[1:])


if __name__ == "__main__":
    main()
