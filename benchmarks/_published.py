"""RatSLAM's loops as they are published (Milford and Wyeth 2010; OpenRatSLAM), written plainly and compiled plainly."""

import math
from typing import Any

import numba
import numpy as np

plainly = numba.njit(cache=True)
EPSILON = 0.005


@plainly
def match(view: Any, mean: float, templates: Any, means: Any, shift: int, threshold: float) -> tuple[int, float]:
    """Return (number, difference) of the best template of those whose mean grey is near; grey from 0 to 1."""
    height, width = view.shape
    least, found = math.inf, -1
    for n in range(templates.shape[0]):
        if abs(mean - means[n]) > threshold + EPSILON:
            continue
        for s in range(2 * shift + 1):
            total = 0.0
            for h in range(height):
                for c in range(width - 2 * shift):
                    total += abs(view[h, c + shift] - templates[n, h, c + s])
                if total > least:
                    break
            if total < least:
                least, found = total, n
    return found, least / (height * (width - 2 * shift))


@plainly
def _wrap(size: int, half: int) -> Any:
    """Return where the cells from `half` before the first to `half` after the last one are."""
    return (np.arange(size + 2 * half) - half) % size


@plainly
def _spread(cells: Any, cube: Any, out: Any) -> None:
    """Spread every active cell over its cube of neighbours."""
    around, across, _ = cells.shape
    width = cube.shape[0]
    layers, lines = _wrap(around, width // 2), _wrap(across, width // 2)
    out[:] = 0.0
    for i in range(across):
        for j in range(across):
            for k in range(around):
                energy = cells[k, j, i]
                if energy != 0.0:
                    for dk in range(width):
                        for dj in range(width):
                            for di in range(width):
                                out[layers[k + dk], lines[j + dj], lines[i + di]] += energy * cube[dk, dj, di]


def cube(width: int, sd: float) -> np.ndarray:
    """Return the weights, (width, width, width), of sum 1."""
    grid = np.indices((width,) * 3) - width // 2
    weights = np.exp(-np.square(grid).sum(axis=0) / (2 * sd * sd))
    made: np.ndarray = weights / weights.sum()
    return made


@plainly
def _shift(excited: Any, between: Any, cells: Any, forward: float, turn: float) -> None:
    """Write into `cells` the excited ones after the motion."""
    around, across, _ = cells.shape
    for k in range(around):
        heading = 2 * math.pi * k / around
        dx, dy = forward * math.cos(heading), forward * math.sin(heading)
        for j in range(across):
            for i in range(across):
                x, y = i - dx, j - dy
                i0, j0 = math.floor(x), math.floor(y)
                fx, fy = x - i0, y - j0
                between[k, j, i] = (
                    (1 - fx) * (1 - fy) * excited[k, j0 % across, i0 % across]
                    + fx * (1 - fy) * excited[k, j0 % across, (i0 + 1) % across]
                    + (1 - fx) * fy * excited[k, (j0 + 1) % across, i0 % across]
                    + fx * fy * excited[k, (j0 + 1) % across, (i0 + 1) % across]
                )
    for k in range(around):
        layer = k - turn
        low = math.floor(layer)
        part = layer - low
        for j in range(across):
            for i in range(across):
                cells[k, j, i] = (1 - part) * between[low % around, j, i] + part * between[(low + 1) % around, j, i]


@plainly
def step(cells: Any, excite: Any, inhibit: Any, inhibit_all: float, forward: float, turn: float) -> None:
    """Let the cells compete and move them by `forward` cells along their headings and `turn` layers; in place."""
    around, across, _ = cells.shape
    excited, inhibited = np.empty_like(cells), np.empty_like(cells)
    _spread(cells, excite, excited)
    _spread(excited, inhibit, inhibited)
    total = 0.0
    for k in range(around):
        for j in range(across):
            for i in range(across):
                left = excited[k, j, i] - inhibited[k, j, i]
                left = left - inhibit_all if left >= inhibit_all else 0.0
                excited[k, j, i] = left
                total += left
    for k in range(around):
        for j in range(across):
            for i in range(across):
                excited[k, j, i] /= total
    _shift(excited, inhibited, cells, forward, turn)


@plainly
def _clipped(angle: float) -> float:
    while angle > math.pi:
        angle -= 2 * math.pi
    while angle <= -math.pi:
        angle += 2 * math.pi
    return angle


@plainly
def relax(x: Any, y: Any, facing: Any, begins: Any, links: Any, ends: Any, measured: Any, loops: int, correction: float) -> None:  # fmt: skip
    """Correct the poses in place; the links of experience n are `links[begins[n]:begins[n + 1]]`."""
    for _ in range(loops):
        for a in range(x.size):
            for n in range(begins[a], begins[a + 1]):
                link = links[n]
                b = ends[link]
                towards = facing[a] + measured[link, 1]
                wanted_x = x[a] + measured[link, 0] * math.cos(towards)
                wanted_y = y[a] + measured[link, 0] * math.sin(towards)
                off_x, off_y = (x[b] - wanted_x) * correction, (y[b] - wanted_y) * correction
                x[a] += off_x
                y[a] += off_y
                x[b] -= off_x
                y[b] -= off_y
                off = _clipped(facing[b] - facing[a] - measured[link, 2]) * correction
                facing[a] = _clipped(facing[a] + off)
                facing[b] = _clipped(facing[b] - off)


@plainly
def dijkstra(begins: Any, ends: Any, seconds: Any, start: int) -> Any:
    """Return the duration to every node; all nodes wait in a heap, which is made anew for every node that is done."""
    count = begins.size - 1
    total = np.full(count, math.inf)
    total[start] = 0.0
    waiting = np.arange(count)
    size = count
    while size > 0:
        for root in range(size // 2 - 1, -1, -1):
            at = root
            while 2 * at + 1 < size:
                below = 2 * at + 1
                if below + 1 < size and total[waiting[below + 1]] < total[waiting[below]]:
                    below += 1
                if total[waiting[at]] <= total[waiting[below]]:
                    break
                waiting[at], waiting[below] = waiting[below], waiting[at]
                at = below
        node = waiting[0]
        if total[node] == math.inf:
            break
        size -= 1
        waiting[0] = waiting[size]
        for n in range(begins[node], begins[node + 1]):
            through = total[node] + seconds[n]
            if through < total[ends[n]]:
                total[ends[n]] = through
    return total
