"""How tests wait: on a condition, with a limit."""

import time  # noqa: TID251 - the limit of a wait

CEILING_S = 120.0  # against hanging alone
shortest_s = 0.0  # no limit of the test that runs is shorter


def wait_for(condition, seconds: float, what: str):
    """Wait on a condition with a limit; return its value. Looks more rarely the longer it lasts, at least each 0.1 s."""
    seconds = max(seconds, shortest_s)
    since = time.monotonic()
    while True:
        waited = time.monotonic() - since  # before it looks: a machine that stalls here looks once more
        value = condition()
        if value:
            return value
        if waited > seconds:
            raise AssertionError(f"{what}: not within {seconds} s")
        time.sleep(min(0.02 + 0.05 * waited, 0.1))
