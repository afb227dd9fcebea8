"""The priority of processes that may wait."""

import os
import time

AUTOGROUP = "/proc/self/autogroup"
TRIES, AGAIN_S = 20, 0.11  # Linux takes one such change of ordinary users in a tenth of a second


def stand_back(by: int) -> None:
    """Make this process nicer by so much (1 to 19), and its session where it leads one.

    Linux shares the processor among sessions first (autogroups), and the supervisor starts each process in a session
    of its own: there the niceness of the process alone changes nothing.
    """
    os.nice(by)
    share_less(by)


def share_less(nice: int) -> bool:
    """Set the niceness of the session that this process leads (0 to 19). Return False if that is not possible.

    The session of somebody else, as of a terminal, stays as it is.
    """
    if os.getsid(0) != os.getpid():
        return False
    for _ in range(TRIES):
        try:
            descriptor = os.open(AUTOGROUP, os.O_WRONLY)
        except OSError:
            return False
        try:
            os.write(descriptor, str(nice).encode())
        except BlockingIOError:
            time.sleep(AGAIN_S)
        except OSError:
            return False
        else:
            return True
        finally:
            os.close(descriptor)
    return False
