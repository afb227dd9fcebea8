"""Angles turned by a rover: wheels slip and a compass is noisy, but together they are much more exact than alone."""

from math import tau

import numpy as np

from robots.kit.rovers.gridmap.plan import Floats

SLIP, SLIP_SPREAD = 0.22, 0.10  # of a turn: 10 to 35 %, the same during one scan
STEP_SPREAD = 0.02  # rad, of one turn besides
COMPASS_SPREAD = 0.05  # rad, of one reading
MOST = 360  # readings of one scan


def headings_of(turns: Floats, compass: Floats) -> Floats:
    """Return the likeliest headings (n,) by n - 1 turns of the encoders and n readings of the compass (rad).

    Least squares for the headings and the slip that all turns share. Raises ValueError for other lengths or numbers.
    """
    count = len(compass)
    if not 1 <= count <= MOST or turns.shape != (count - 1,):
        raise ValueError("There is one turn fewer than readings of the compass.")
    if not (np.isfinite(turns).all() and np.isfinite(compass).all() and (np.abs(turns) < tau).all()):
        raise ValueError("Turns and headings are finite numbers.")
    ahead = (1.0 - SLIP) * turns
    steps = ahead + np.remainder(np.diff(compass) - ahead + np.pi, tau) - np.pi
    seen = compass[0] + np.concatenate([[0.0], np.cumsum(steps)])
    left = np.zeros((2 * count, count + 1))  # unknown: the headings, then the slip
    right = np.zeros(2 * count)
    rows = np.arange(count - 1)
    left[rows, rows], left[rows, rows + 1], left[rows, count] = -1.0, 1.0, turns
    right[rows] = turns
    left[: count - 1] /= STEP_SPREAD
    right[: count - 1] /= STEP_SPREAD
    each = np.arange(count)
    left[count - 1 + each, each] = 1.0 / COMPASS_SPREAD
    right[count - 1 : 2 * count - 1] = seen / COMPASS_SPREAD
    left[-1, count], right[-1] = 1.0 / SLIP_SPREAD, SLIP / SLIP_SPREAD
    return np.asarray(np.linalg.lstsq(left, right, rcond=None)[0][:count], float)
