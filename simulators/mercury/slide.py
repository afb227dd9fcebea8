"""How dry sand slides: nowhere steeper than its angle of repose, in any direction.

Sand flows down the steepest slope, in proportion to how much too steep that slope is: a diffusion that stops below
the angle of repose. (With the two axes treated separately, sand would form square pyramids whose edges are steeper by
half.) A diffusion is slow over large distances, so these are computed on coarser grids first.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import zoom

F32 = NDArray[np.float32]
REPOSE = float(np.tan(np.radians(33.0)))
RATE = np.float32(0.2)  # share of the excess that flows each round; above 0.25 the scheme is unstable
AT_REST_MM = 0.002  # flow per round below which the motion is not visible
LOOK = 8  # rounds between two checks for rest
CYCLES, COARSEST, COARSE, FINE = 6, 100, 40, 24  # rounds at most, on grids of 4, 2 and 1 mm
LAST = 60


def slide(sand: F32, rigid: F32) -> None:
    """Let sand of shape (rows, columns) slide in place until it rests; heights in mm on a 1 mm grid.

    Nothing leaves the window, nothing sinks below `rigid`, and the amount stays the same.
    """
    for _ in range(CYCLES):
        _coarsely(sand, rigid, 4, COARSEST)
        _coarsely(sand, rigid, 2, COARSE)
        if _rests(sand, rigid, 1, FINE):
            return
    _rests(sand, rigid, 1, LAST)


def steeper(sand: F32) -> NDArray[np.bool_]:
    """Return where the sand is too steep by more than a degree."""
    down, along = _slopes(sand)
    return np.asarray(np.hypot(down, along) > REPOSE * 1.04)


def _rests(sand: F32, rigid: F32, cell_mm: int, rounds: int) -> bool:
    """Let it slide so many rounds on a grid of `cell_mm`; return whether it came to rest."""
    for i in range(rounds):
        along_x, along_y = _flow(sand, (sand - rigid) * RATE, np.float32(REPOSE * cell_mm))
        sand[:, 1:] -= along_x
        sand[:, :-1] += along_x
        sand[1:] -= along_y
        sand[:-1] += along_y
        if i % LOOK == LOOK - 1 and max(np.abs(along_x).max(), np.abs(along_y).max()) < AT_REST_MM * cell_mm:
            return True
    return False


def _flow(sand: F32, free: F32, greatest: np.float32) -> tuple[F32, F32]:
    """Return the flow through the faces between columns and between rows, towards the lower index.

    `free` is the amount that a cell may lose through one face, `greatest` the step that is stable.
    """
    slope_y, slope_x = _slopes(sand)
    step_x, step_y = np.diff(sand, axis=1), np.diff(sand, axis=0)
    across_x = (slope_y[:, 1:] + slope_y[:, :-1]) / 2
    across_y = (slope_x[1:] + slope_x[:-1]) / 2
    steep_x = np.sqrt(step_x * step_x + across_x * across_x)
    steep_y = np.sqrt(step_y * step_y + across_y * across_y)
    along_x = step_x * (RATE - RATE * greatest / np.maximum(steep_x, greatest))
    along_y = step_y * (RATE - RATE * greatest / np.maximum(steep_y, greatest))
    return np.clip(along_x, -free[:, :-1], free[:, 1:]), np.clip(along_y, -free[:-1], free[1:])


def _slopes(field: F32) -> tuple[F32, F32]:
    down, along = np.gradient(field)
    return np.asarray(down, np.float32), np.asarray(along, np.float32)


def _coarsely(sand: F32, rigid: F32, by: int, rounds: int) -> None:
    """Let it slide on a grid `by` times as coarse, and apply the change to the fine sand."""
    rows, columns = (n // by * by for n in sand.shape)
    fine, floor = sand[:rows, :columns], rigid[:rows, :columns]
    before, low = _means(fine, by), _means(floor, by)
    after = before.copy()
    _rests(after, low, by, rounds)
    change = zoom(after - before, by, order=1, mode="nearest", grid_mode=True)
    taken = np.clip(change, floor - fine, 0)
    given = np.maximum(change, 0)
    total = float(given.sum(dtype=np.float64))
    if total > 0:  # sand on an object could not be taken, so less is given
        fine += taken + given * np.float32(-float(taken.sum(dtype=np.float64)) / total)


def _means(field: F32, by: int) -> F32:
    rows, columns = field.shape
    return np.asarray(field.reshape(rows // by, by, columns // by, by).mean((1, 3)), np.float32)
