"""Keeps a map small enough for days: of the experiences that stand and face alike, one stays.

Milford and Wyeth 2010 ("Persistent navigation and mapping using a biologically inspired SLAM system") keep the
density of experiences bounded and hand the links of one that goes to its neighbour. Which one stays is ours: the one
last visited, because it looks as the place looks now.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from robots.autonomy.ratslam.experiences import LINKS, NODES, ExperienceMap, composed, inverted

Numbers = NDArray[np.int64]


def survivors(held: ExperienceMap, protected: frozenset[int]) -> Numbers:
    """Return for each experience the index of the one that stands for it afterwards: itself if it stays."""
    kept, n = held.settings, held.count
    poses = held.poses[:n]
    squares = np.floor(poses[:, :2] / kept.square_m).astype(np.int64)
    headings = np.floor(poses[:, 2] / (2 * np.pi) * kept.headings).astype(np.int64) % kept.headings
    _, group = np.unique(np.column_stack([squares, headings]), axis=0, return_inverse=True)
    group = group.reshape(-1)
    needed = np.isin(held.ids[:n], np.array(sorted(protected), np.int64))
    if held.current >= 0:
        needed[held.current] = True
    stands = np.arange(n)
    order = np.lexsort((held.visited[:n], needed))  # the most wanted last
    best = np.zeros(group.max(initial=-1) + 1, np.int64)
    best[group[order]] = order
    return np.where(needed, stands, best[group])


def contract(held: ExperienceMap, stands: Numbers) -> Numbers:
    """Remove what does not stand for itself, hand its links on, and return the old indices of what is left."""
    left = np.flatnonzero(stands == np.arange(held.count))
    renumbered = np.cumsum(stands == np.arange(held.count)) - 1
    seen: set[tuple[int, int]] = set()
    kept: list[int] = []
    for link in range(held.linked):
        a, b = int(held.sources[link]), int(held.targets[link])
        on, to = int(stands[a]), int(stands[b])
        pair = (min(on, to), max(on, to))
        if on == to or pair in seen:
            continue
        seen.add(pair)
        kept.append(link)
        if (on, to) != (a, b):
            _measure_anew(held, link, on, to)
    for name, _, _ in LINKS:
        array = getattr(held, name)
        array[: len(kept)] = array[kept]
    held.linked = len(kept)
    for name in ("sources", "targets"):
        array = getattr(held, name)
        array[: held.linked] = renumbered[array[: held.linked]]
    for name, _, _ in NODES:
        array = getattr(held, name)
        array[: len(left)] = array[left]
    held.count, held.current = len(left), int(renumbered[held.current]) if held.current >= 0 else -1
    ends = zip(held.sources[: held.linked].tolist(), held.targets[: held.linked].tolist(), strict=True)
    held.pairs = {(min(a, b), max(a, b)) for a, b in ends}
    return left


def _measure_anew(held: ExperienceMap, link: int, on: int, to: int) -> None:
    """Let a link lead from `on` to `to`, which stand for its ends, by their poses on the map."""
    distance, direction, facing = (float(value) for value in held.measured[link])
    measured = (distance * np.cos(direction), distance * np.sin(direction), facing)
    before = composed(inverted(held.pose_of(on)), held.pose_of(int(held.sources[link])))
    after = composed(inverted(held.pose_of(int(held.targets[link]))), held.pose_of(to))
    x, y, facing = composed(composed(before, measured), after)
    held.sources[link], held.targets[link] = on, to
    held.measured[link] = np.hypot(x, y), np.arctan2(y, x), facing


def pruned(
    held: ExperienceMap, protected: frozenset[int], keep_views: Callable[[Numbers], None]
) -> tuple[int, dict[int, int]]:
    """Prune the map, and the templates that no experience uses any more by `keep_views`.

    Return how many experiences went, and the new number of each template that is left.
    """
    before = held.count
    contract(held, survivors(held, protected))
    used = np.unique(held.views[: held.count])
    keep_views(used)
    held.views[: held.count] = np.searchsorted(used, held.views[: held.count])
    return before - held.count, {int(old): new for new, old in enumerate(used)}
