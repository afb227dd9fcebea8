"""The rate of pictures in a recording: lower as its file nears the greatest size, then none."""

from math import inf

ALONE_S, BESIDE_S = 0.2, 0.4  # between two pictures of a robot's only camera, and of one among several
FULL_RATE = 0.5  # the share of the size up to which pictures keep their rate
STEP = 0.1  # with each further share of this size pictures come half as often
LAST = 0.95  # from here on there are states, commands and events only


def picture_every_s(used: int, limit: int, cameras: int) -> float:
    """Return the least time (s) between two pictures of one camera; infinite where none are taken any more."""
    share = used / limit if limit > 0 else 1.0
    if share >= LAST:
        return inf
    steps = 0 if share < FULL_RATE else 1 + int((share - FULL_RATE) / STEP + 1e-9)
    return float((ALONE_S if cameras <= 1 else BESIDE_S) * 2**steps)
