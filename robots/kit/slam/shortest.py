"""Dijkstra's algorithm on the links of a map, both ways along each, with a binary heap."""

import numpy as np
from numpy.typing import NDArray

from robots.kit.compiled import compiled

Values = NDArray[np.float64]
Numbers = NDArray[np.int64]


@compiled
def _neighbours(sources: Numbers, targets: Numbers, durations: Values, count: int) -> tuple[Numbers, Numbers, Values]:
    """Return where each node's neighbours begin, (count + 1,), the neighbours, and the durations (s) to them."""
    begins = np.zeros(count + 1, np.int64)
    for n in range(sources.size):
        begins[sources[n] + 1] += 1
        begins[targets[n] + 1] += 1
    for n in range(count):
        begins[n + 1] += begins[n]
    free = begins[:-1].copy()
    ends, costs = np.empty(2 * sources.size, np.int64), np.empty(2 * sources.size)
    for n in range(sources.size):
        a, b = sources[n], targets[n]
        ends[free[a]], costs[free[a]] = b, durations[n]
        free[a] += 1
        ends[free[b]], costs[free[b]] = a, durations[n]
        free[b] += 1
    return begins, ends, costs


@compiled
def _push(keys: Values, nodes: Numbers, size: int, key: float, node: int) -> None:
    """Add to a heap of `size`."""
    at = size
    while at > 0:
        above = (at - 1) >> 1
        if keys[above] <= key:
            break
        keys[at], nodes[at] = keys[above], nodes[above]
        at = above
    keys[at], nodes[at] = key, node


@compiled
def _pop(keys: Values, nodes: Numbers, size: int) -> None:
    """Take the first off a heap of `size`."""
    key, node = keys[size - 1], nodes[size - 1]
    size -= 1
    at = 0
    while True:
        below = 2 * at + 1
        if below >= size:
            break
        if below + 1 < size and keys[below + 1] < keys[below]:
            below += 1
        if keys[below] >= key:
            break
        keys[at], nodes[at] = keys[below], nodes[below]
        at = below
    keys[at], nodes[at] = key, node


@compiled
def shortest(
    sources: Numbers, targets: Numbers, durations: Values, count: int, begin: int, goal: int, least: float
) -> tuple[float, Numbers]:
    """Return the duration (s) to `goal`, infinite if no links lead there, and the nodes from `begin` to it.

    A link takes at least `least` seconds, which is more than 0.
    """
    begins, ends, costs = _neighbours(sources, targets, durations, count)
    total, before = np.full(count, np.inf), np.full(count, -1, np.int64)
    keys, nodes = np.empty(ends.size + 1), np.empty(ends.size + 1, np.int64)
    total[begin], size = 0.0, 1
    keys[0], nodes[0] = 0.0, begin
    while size > 0 and nodes[0] != goal:
        key, node = keys[0], nodes[0]
        _pop(keys, nodes, size)
        size -= 1
        if key > total[node]:
            continue  # a longer way to a node that is done
        for n in range(begins[node], begins[node + 1]):
            other, through = ends[n], key + max(costs[n], least)
            if through < total[other]:
                total[other], before[other] = through, node
                _push(keys, nodes, size, through, other)
                size += 1
    way = np.empty(count, np.int64)
    way[0], length = goal, 1
    while way[length - 1] != begin and before[way[length - 1]] >= 0:
        way[length] = before[way[length - 1]]
        length += 1
    return total[goal], way[:length][::-1]
