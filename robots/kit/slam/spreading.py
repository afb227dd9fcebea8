"""The loops of the pose cells. Cells are (heading, y, x); every axis wraps around.

The weights of the published network are a normal distribution cut to a cube. Its exponential is a product of three,
one an axis, so a cube of 7 x 7 x 7 weights is three lines of 7: the same sum in a sixteenth of the operations.
"""

import math

import numpy as np
from numpy.typing import NDArray

from robots.kit.compiled import compiled

Cells = NDArray[np.float64]


def line(width: int, sd: float) -> Cells:
    """Return the weights of one axis, (width,), of sum 1."""
    found = np.exp(-np.square(np.arange(width) - width // 2) / (2.0 * sd * sd))
    weights: Cells = found / found.sum()
    return weights


@compiled
def _along_x(cells: Cells, weights: Cells, out: Cells) -> None:
    around, across, _ = cells.shape
    half = weights.size // 2
    row = np.empty(across + 2 * half)  # with the cells beyond both edges
    for k in range(around):
        for j in range(across):
            for i in range(row.size):
                row[i] = cells[k, j, (i - half) % across]
            for i in range(across):
                out[k, j, i] = 0.0
            for n in range(weights.size):
                for i in range(across):
                    out[k, j, i] += weights[n] * row[i + n]


@compiled
def _along_y(cells: Cells, weights: Cells, out: Cells) -> None:
    around, across, _ = cells.shape
    half = weights.size // 2
    for k in range(around):
        for j in range(across):
            for i in range(across):
                out[k, j, i] = 0.0
            for n in range(weights.size):
                other = (j + n - half) % across
                for i in range(across):
                    out[k, j, i] += weights[n] * cells[k, other, i]


@compiled
def _along_heading(cells: Cells, weights: Cells, out: Cells) -> None:
    around, across, _ = cells.shape
    half = weights.size // 2
    for k in range(around):
        out[k] = 0.0
        for n in range(weights.size):
            other = (k + n - half) % around
            for j in range(across):
                for i in range(across):
                    out[k, j, i] += weights[n] * cells[other, j, i]


@compiled
def _spread(cells: Cells, weights: Cells, between: Cells, out: Cells) -> None:
    """Write into `out` the cells, each spread over its neighbours along all three axes."""
    _along_x(cells, weights, out)
    _along_y(out, weights, between)
    _along_heading(between, weights, out)


@compiled
def compete(cells: Cells, excite: Cells, inhibit: Cells, inhibit_all: float) -> bool:
    """Excite, inhibit and normalise the sum to 1, in place; tell whether any activity was left.

    If none was left, the cells stay as they were.
    """
    between, excited, inhibited = np.empty_like(cells), np.empty_like(cells), np.empty_like(cells)
    _spread(cells, excite, between, excited)
    _spread(excited, inhibit, between, inhibited)
    total = 0.0
    around, across, _ = cells.shape
    for k in range(around):
        for j in range(across):
            for i in range(across):
                left = excited[k, j, i] - inhibited[k, j, i] - inhibit_all
                if left < 0.0:
                    left = 0.0
                excited[k, j, i] = left
                total += left
    if not 0.0 < total < math.inf:
        return False
    for k in range(around):
        for j in range(across):
            for i in range(across):
                cells[k, j, i] = excited[k, j, i] / total
    return True


@compiled
def shift(cells: Cells, forward: float, turn: float) -> None:
    """Move the activity by `forward` cells, in each layer along its heading, and turn it by `turn` layers, in place.

    A part of a cell is shared linearly between neighbours; the sum stays.
    """
    around, across, _ = cells.shape
    moved = np.empty_like(cells)
    for k in range(around):
        heading = 2.0 * math.pi * k / around
        dx, dy = forward * math.cos(heading), forward * math.sin(heading)
        ix, iy = math.floor(dx), math.floor(dy)
        fx, fy = dx - ix, dy - iy
        for j in range(across):
            near, far = (j - iy) % across, (j - iy - 1) % across
            for i in range(across):
                this, last = (i - ix) % across, (i - ix - 1) % across
                moved[k, j, i] = (1.0 - fy) * ((1.0 - fx) * cells[k, near, this] + fx * cells[k, near, last]) + fy * (
                    (1.0 - fx) * cells[k, far, this] + fx * cells[k, far, last]
                )
    whole = math.floor(turn)
    part = turn - whole
    for k in range(around):
        this, last = (k - whole) % around, (k - whole - 1) % around
        for j in range(across):
            for i in range(across):
                cells[k, j, i] = (1.0 - part) * moved[this, j, i] + part * moved[last, j, i]


@compiled
def _centre(sums: Cells) -> float:
    """Return the mean position on a ring of cells, from the activity of each."""
    east = north = 0.0
    for i in range(sums.size):
        angle = 2.0 * math.pi * i / sums.size
        east += sums[i] * math.cos(angle)
        north += sums[i] * math.sin(angle)
    return math.atan2(north, east) / (2.0 * math.pi) * sums.size % sums.size


@compiled
def peak(cells: Cells, reach: int) -> tuple[float, float, float]:
    """Return (x, y, heading) in cells: the mean of the activity within `reach` cells of the strongest one."""
    around, across, _ = cells.shape
    strongest, best = -1.0, (0, 0, 0)
    for k in range(around):
        for j in range(across):
            for i in range(across):
                if cells[k, j, i] > strongest:
                    strongest, best = cells[k, j, i], (k, j, i)
    xs, ys, headings = np.zeros(across), np.zeros(across), np.zeros(around)
    for dk in range(-reach, reach + 1):
        k = (best[0] + dk) % around
        for dj in range(-reach, reach + 1):
            j = (best[1] + dj) % across
            for di in range(-reach, reach + 1):
                i = (best[2] + di) % across
                energy = cells[k, j, i]
                xs[i] += energy
                ys[j] += energy
                headings[k] += energy
    return _centre(xs), _centre(ys), _centre(headings)
