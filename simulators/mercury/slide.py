"""The slide of dry sand: nowhere steeper than its angle of repose, in any direction.

Sand flows down the steepest slope, in proportion to how much too steep that slope is: a diffusion that stops below
the angle of repose. (With the two axes treated separately, sand would form square pyramids whose edges are steeper by
half.) A diffusion is slow over large distances, so these are computed on coarser grids first.
"""

import numpy as np
from numpy.typing import NDArray

F32 = NDArray[np.float32]
Part = tuple[slice, slice]  # rows and columns
REPOSE = float(np.tan(np.radians(33.0)))
RATE = np.float32(0.2)  # share of the excess that flows each round; above 0.25 the scheme is unstable
AT_REST_MM = 0.002  # flow per round below which the motion is not visible
LOOK = 8  # rounds between two checks for rest
MARGIN = LOOK + 2  # cells: in a round, sand gets one cell further
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


def finer(field: F32, by: int) -> F32:
    """Return the field on a grid `by` (even) times as fine, linear between the middles of its cells."""
    rows, columns = field.shape
    tall, fine = np.empty((rows, by, columns), np.float32), np.empty((rows * by, columns, by), np.float32)
    for i in range(by):
        tall[:, i] = _between(field, (i + 0.5) / by - 0.5)
    higher = tall.reshape(rows * by, columns)
    for i in range(by):
        fine[:, :, i] = _between(higher.T, (i + 0.5) / by - 0.5).T
    return fine.reshape(rows * by, columns * by)


def _between(field: F32, far: float) -> F32:
    """Return the field so far (cells, up to a half) after the middle of each row; it is level beyond the outermost."""
    found = field * np.float32(1 - abs(far))
    aside = field * np.float32(abs(far))
    if far < 0:
        found[1:] += aside[:-1]
        found[0] += aside[0]
    else:
        found[:-1] += aside[1:]
        found[-1] += aside[-1]
    return found


def steeper(sand: F32) -> NDArray[np.bool_]:
    """Return where the sand is too steep by more than a degree."""
    down, along = _slopes(sand)
    return np.asarray(np.hypot(down, along) > REPOSE * 1.04)


def _rests(sand: F32, rigid: F32, cell_mm: int, rounds: int) -> bool:
    """Let it slide so many rounds on a grid of `cell_mm`; return whether it came to rest.

    Most of a window lies still: where sand flows is looked up every few rounds, and the rest is not computed.
    """
    inside: Part = (slice(0, sand.shape[0]), slice(0, sand.shape[1]))
    for i in range(rounds):
        part = sand[inside]
        along_x, along_y = _flow(part, (part - rigid[inside]) * RATE, np.float32(REPOSE * cell_mm))
        part[:, 1:] -= along_x
        part[:, :-1] += along_x
        part[1:] -= along_y
        part[:-1] += along_y
        if i % LOOK == LOOK - 1 and max(np.abs(along_x).max(), np.abs(along_y).max()) < AT_REST_MM * cell_mm:
            return True
        if i % LOOK == 0:
            inside = _flowing(along_x, along_y, 0.1 * AT_REST_MM * cell_mm, inside, sand.shape)
    return False


def _flowing(along_x: F32, along_y: F32, least: float, inside: Part, shape: tuple[int, ...]) -> Part:
    """Return the part in which the flows of `inside` are more than `least`, and what they can reach until the next."""
    flows = np.zeros((along_x.shape[0], along_y.shape[1]), np.bool_)
    flows[:, 1:] |= np.abs(along_x) > least
    flows[1:] |= np.abs(along_y) > least
    found = []
    for axis, (was, length) in enumerate(zip(inside, shape, strict=True)):
        places = np.flatnonzero(flows.any(1 - axis)) + was.start
        if not len(places):
            return inside
        found.append(slice(max(0, int(places[0]) - MARGIN), min(length, int(places[-1]) + MARGIN)))
    return found[0], found[1]


def _flow(sand: F32, free: F32, greatest: np.float32) -> tuple[F32, F32]:
    """Return the flow through the faces between columns and between rows, towards the lower index.

    `free` is the amount that a cell may lose through one face, `greatest` the step that is stable.
    """
    slope_y, slope_x = _slopes(sand)
    along_x = _down(sand[:, 1:] - sand[:, :-1], slope_y[:, 1:] + slope_y[:, :-1], greatest)
    along_y = _down(sand[1:] - sand[:-1], slope_x[1:] + slope_x[:-1], greatest)
    np.minimum(np.maximum(along_x, -free[:, :-1], out=along_x), free[:, 1:], out=along_x)
    np.minimum(np.maximum(along_y, -free[:-1], out=along_y), free[1:], out=along_y)
    return along_x, along_y


def _down(step: F32, across: F32, greatest: np.float32) -> F32:
    """Return the flow for a step between two cells; `across`: the slope along their face, twice. Both are used up."""
    share = across
    share *= np.float32(0.5)
    share *= share
    share += step * step
    np.maximum(np.sqrt(share, out=share), greatest, out=share)
    np.subtract(RATE, np.divide(RATE * greatest, share, out=share), out=share)
    step *= share
    return step


def _slopes(field: F32) -> tuple[F32, F32]:
    """Return the slope from row to row and from column to column, as `np.gradient` does and in much less time."""
    down, along = np.empty_like(field), np.empty_like(field)
    for slope, across in ((down, field), (along.T, field.T)):
        np.subtract(across[2:], across[:-2], out=slope[1:-1])
        slope[1:-1] *= np.float32(0.5)
        slope[0], slope[-1] = across[1] - across[0], across[-1] - across[-2]
    return down, along


def _coarsely(sand: F32, rigid: F32, by: int, rounds: int) -> None:
    """Let it slide on a grid `by` times as coarse, and apply the change to the fine sand."""
    rows, columns = (n // by * by for n in sand.shape)
    fine, floor = sand[:rows, :columns], rigid[:rows, :columns]
    before, low = _means(fine, by), _means(floor, by)
    after = before.copy()
    _rests(after, low, by, rounds)
    change = finer(after - before, by)
    taken = np.clip(change, floor - fine, 0)
    given = np.maximum(change, 0)
    total = float(given.sum(dtype=np.float64))
    if total > 0:  # sand on an object could not be taken, so less is given
        fine += taken + given * np.float32(-float(taken.sum(dtype=np.float64)) / total)


def _means(field: F32, by: int) -> F32:
    rows, columns = field.shape
    return np.asarray(field.reshape(rows // by, by, columns // by, by).mean((1, 3)), np.float32)
