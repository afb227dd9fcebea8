"""Keeps a map small enough for days: of the experiences that stand and face alike, one stays.

Milford and Wyeth 2010 ("Persistent navigation and mapping using a biologically inspired SLAM system") keep the
density of experiences bounded. Which one stays is ours: the one last visited, because it looks as the place looks now.
One that goes hands its links to the nearest experience that it is linked with, never to one that only lies beside it on
the map: where the map is not right yet, that may be another place.
"""

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from robots.autonomy.ratslam.experiences import LINKS, NODES, ExperienceMap, Pose, composed, inverted

Numbers = NDArray[np.int64]
Ways = list[dict[int, tuple[Pose, float]]]  # for each experience, those it is linked with: seen where, and how long (s)


def standing(held: ExperienceMap, protected: frozenset[int]) -> Numbers:
    """Return for each experience the index of the one that stays for it: its own, if it stays.

    The last visited of each square and heading stays, and what is protected.
    """
    kept, n = held.settings, held.count
    poses = held.poses[:n]
    squares = np.floor(poses[:, :2] / kept.square_m).astype(np.int64)
    headings = np.floor(poses[:, 2] / (2 * np.pi) * kept.headings).astype(np.int64) % kept.headings
    _, group = np.unique(np.column_stack([squares, headings]), axis=0, return_inverse=True)
    group = group.reshape(-1)
    needed: NDArray[np.bool_] = np.isin(held.ids[:n], np.array(sorted(protected), np.int64))
    if held.current >= 0:
        needed[held.current] = True
    order = np.lexsort((held.visited[:n], needed))  # the most wanted last
    best = np.zeros(group.max(initial=-1) + 1, np.int64)
    best[group[order]] = order
    return np.where(needed, np.arange(n), best[group])


def _ways(held: ExperienceMap) -> Ways:
    found: Ways = [{} for _ in range(held.count)]
    for n in range(held.linked):
        a, b = int(held.sources[n]), int(held.targets[n])
        distance, direction, facing = held.measured[n].tolist()
        seen = (distance * math.cos(direction), distance * math.sin(direction), facing)
        found[a][b] = (seen, float(held.durations[n]))
        found[b][a] = (inverted(seen), float(held.durations[n]))
    return found


def _merge(ways: Ways, gone: int) -> None:
    """Hand the links of an experience to the nearest one that it is linked with; what they measured is added up."""
    links = ways[gone]
    heir = min(links, key=lambda other: (math.hypot(*links[other][0][:2]), other))
    onto, seconds = links.pop(heir)
    del ways[heir][gone]
    for other, (seen, long) in links.items():
        del ways[other][gone]
        through = composed(inverted(seen), onto), long + seconds  # the heir as seen from the other one
        if heir not in ways[other] or ways[other][heir][1] > through[1]:
            ways[other][heir] = through
            ways[heir][other] = inverted(through[0]), through[1]
    ways[gone] = {}


def contract(held: ExperienceMap, stays: NDArray[np.bool_]) -> None:
    """Remove what does not stay; all that is left is linked as before, if more loosely."""
    ways = _ways(held)
    for index in np.flatnonzero(~stays).tolist():
        _merge(ways, index)
    left = np.flatnonzero(stays)
    renumbered = (np.cumsum(stays) - 1).tolist()
    for name, _, _ in NODES:
        array = getattr(held, name)
        array[: len(left)] = array[left]
    pairs = [(a, b, *ways[a][b]) for a in left.tolist() for b in sorted(ways[a]) if a < b]
    for name, shape, kind in LINKS:
        setattr(held, name, np.zeros((max(64, len(pairs)), *shape), kind))
    for n, (a, b, seen, seconds) in enumerate(pairs):
        held.sources[n], held.targets[n], held.durations[n] = renumbered[a], renumbered[b], seconds
        held.measured[n] = math.hypot(seen[0], seen[1]), math.atan2(seen[1], seen[0]), seen[2]
    held.count, held.linked = len(left), len(pairs)
    held.current = renumbered[held.current] if held.current >= 0 else -1
    held.pairs = {(renumbered[a], renumbered[b]) for a, b, _, _ in pairs}


def pruned(
    held: ExperienceMap, protected: frozenset[int], keep_views: Callable[[Numbers], None]
) -> tuple[dict[int, int], dict[int, int]]:
    """Prune the map, and the templates that no experience uses any more by `keep_views`.

    Return for the id of each experience that went the id of the one that stays where it was, and the new number of
    each template that is left.
    """
    stand = standing(held, protected)
    gone = np.flatnonzero(stand != np.arange(held.count))
    heirs = dict(zip(held.ids[gone].tolist(), held.ids[stand[gone]].tolist(), strict=True))
    contract(held, stand == np.arange(held.count))
    used = np.unique(held.views[: held.count])
    keep_views(used)
    held.views[: held.count] = np.searchsorted(used, held.views[: held.count])
    return heirs, {int(old): new for new, old in enumerate(used)}
