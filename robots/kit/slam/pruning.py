"""Keeps a map small enough for days: of the experiences that stand and face alike, one stays.

Milford and Wyeth 2010 ("Persistent navigation and mapping using a biologically inspired SLAM system") keep the
density of experiences bounded: the links of one that goes are handed to the one that stays in its place, corrected by
where the map has the two. Ours: such a link has the map's error in it, so it is measured anew when the robot goes that
way again (`ExperienceMap._arrive`). And the oldest stays, because what was measured to and from it is kept, unless it
was not recognised for long, when the place looks otherwise now.
And two are one place only if a short path over links leads from one to the other. Where the map is not right yet, two
places may overlap; those stay apart until the robot has closed the loop.
"""

import heapq
import math
from collections.abc import Callable, Iterable

import numpy as np
from numpy.typing import NDArray

from robots.kit.slam.experiences import LINKS, NODES, ExperienceMap, Pose, composed, inverted

Numbers = NDArray[np.int64]
Flags = NDArray[np.bool_]
Link = tuple[Pose, float, bool]  # seen where, after how long (s), whether the robot has measured it
Links = list[dict[int, Link]]  # of each experience: linked with which, and how
SHORT_M = 0.01  # a shorter link is mostly a turn


def alike(held: ExperienceMap, protected: frozenset[int], wanted: frozenset[int]) -> list[list[int]]:
    """Return the experiences (indices) of each square and heading, the most wanted first.

    What is protected comes first, then what is wanted, then what was visited lately and more than once, then what was
    not visited for long, then what is new; of each the oldest.
    """
    n, keys = held.count, places(held)
    needed, old = needs(held, protected), stale(held)
    rank = np.where(old, 1, np.where(held.met[:n] > 0, 0, 2))
    chosen = np.isin(held.ids[:n], np.array(sorted(wanted), np.int64))
    order = np.lexsort((held.ids[:n], rank, ~chosen, ~needed, *keys.T[::-1]))
    keys = keys[order]
    return [part.tolist() for part in np.split(order, np.flatnonzero((np.diff(keys, axis=0) != 0).any(axis=1)) + 1)]


def places(held: ExperienceMap) -> Numbers:
    """Return the square (x, y) and the heading of each experience, (count, 3)."""
    kept, poses = held.settings, held.poses[: held.count]
    squares = np.floor(poses[:, :2] / kept.square_m).astype(np.int64)
    headings = np.floor(poses[:, 2] / (2 * np.pi) * kept.headings).astype(np.int64) % kept.headings
    return np.column_stack([squares, headings])


def same_place(held: ExperienceMap, stand: Numbers) -> Flags:
    """Tell of each experience whether the one that stays for it is in its square and faces as it does."""
    where = places(held)
    found: Flags = (where == where[stand]).all(axis=1)
    return found


def stale(held: ExperienceMap) -> Flags:
    """Tell of each experience whether it was not recognised for so long that its place may look otherwise now."""
    found: Flags = held.visited[: held.count] <= held.arrivals - held.settings.stale_after
    return found


def forgotten(held: ExperienceMap, stays: frozenset[int]) -> Flags:
    """Tell of each experience whether it was never recognised, though there was time enough; none of `stays` (ids)."""
    n = held.count
    old = held.visited[:n] <= held.arrivals - held.settings.forgotten_after
    found: Flags = old & (held.met[:n] == 0) & ~needs(held, stays)
    return found


def needs(held: ExperienceMap, protected: frozenset[int]) -> Flags:
    """Tell of each experience whether it stays in any case: it is protected, or the current one."""
    needed: Flags = np.isin(held.ids[: held.count], np.array(sorted(protected), np.int64))
    if held.current >= 0:
        needed[held.current] = True
    return needed


def standing(held: ExperienceMap, protected: frozenset[int], wanted: frozenset[int] = frozenset()) -> Numbers:
    """Return for each experience the index of the one that stays for it: its own, if it stays."""
    stand, needed, links = np.arange(held.count), needs(held, protected), _links(held)
    old, leaves = stale(held), forgotten(held, protected | wanted)
    new = ~old & (held.met[: held.count] == 0)  # until it is met again it replaces nothing, and nothing old it
    for group in alike(held, protected, wanted):
        stay: list[int] = []
        for index in (i for i in group if not leaves[i]):
            heirs = [heir for heir in stay if not (new[index] and old[heir])]
            heir = None if needed[index] or not heirs else _near(links, index, heirs, held.settings.same_m)
            if heir is None:
                stay.append(index)
            else:
                stand[index] = heir[0]
    stays = np.flatnonzero(~leaves & (stand == np.arange(held.count))).tolist()
    for index in np.flatnonzero(leaves).tolist():
        heir = _near(links, index, stays, held.settings.same_m)
        if heir is not None:
            stand[index] = heir[0]
    return stand


def _near(links: Links, begin: int, wanted: Iterable[int], within: float) -> tuple[int, Pose] | None:
    """Return the first of `wanted` in the order of the path over links, None if none is within so many metres.

    With it, how it sees the beginning, as what was measured on the path adds up.
    """
    ends, far, heap = set(wanted), {begin: 0.0}, [(0.0, begin, (0.0, 0.0, 0.0))]
    while heap:
        gone, index, seen = heapq.heappop(heap)
        if index in ends:
            return index, inverted(seen)
        if gone > far[index]:
            continue
        for other, (step, *_) in links[index].items():
            through = gone + math.hypot(step[0], step[1])
            if through <= within and through < far.get(other, math.inf):
                far[other] = through
                heapq.heappush(heap, (through, other, composed(seen, step)))
    return None


def _links(held: ExperienceMap) -> Links:
    found: Links = [{} for _ in range(held.count)]
    for n in range(held.linked):
        a, b = int(held.sources[n]), int(held.targets[n])
        distance, direction, facing = held.measured[n].tolist()
        seen = (distance * math.cos(direction), distance * math.sin(direction), facing)
        seconds, taken = float(held.durations[n]), bool(held.taken[n])
        found[a][b] = (seen, seconds, taken)
        found[b][a] = (inverted(seen), seconds, taken)
    return found


def _pace(held: ExperienceMap) -> float:
    """Return how long a metre takes (s), the median of all links that are one."""
    far = held.measured[: held.linked, 0] > SHORT_M
    paces = held.durations[: held.linked][far] / held.measured[: held.linked, 0][far]
    return float(np.median(paces)) if len(paces) else 0.0


def _merge(links: Links, gone: int, heir: int, apart: Pose, pace: float) -> None:
    """Hand the links of an experience to the one that stays, which sees it at `apart`.

    A link that gets longer by a metre takes longer by `pace` (s/m), and back. Of two between the same experiences the
    one that was there stays.
    """
    for other, (seen, seconds, _) in links[gone].items():
        del links[other][gone]
        if other == heir or heir in links[other]:
            continue
        now = composed(apart, seen)
        was_m, now_m = math.hypot(*seen[:2]), math.hypot(*now[:2])
        seconds = max(seconds + pace * (now_m - was_m), pace * now_m / 2)
        links[heir][other], links[other][heir] = (now, seconds, False), (inverted(now), seconds, False)
    links[gone] = {}


def contract(held: ExperienceMap, stand: Numbers) -> None:
    """Remove each experience that another stands for; its links lead to that one then."""
    links, stays, pace = _links(held), stand == np.arange(held.count), _pace(held)
    gone = np.flatnonzero(~stays).tolist()
    apart, same = {}, same_place(held, stand)
    for index, heir in ((index, int(stand[index])) for index in gone):
        measured = None if same[index] else _near(links, index, (heir,), held.settings.same_m)
        apart[index] = measured[1] if measured else composed(inverted(held.pose_of(heir)), held.pose_of(index))
    for index in gone:
        _merge(links, index, int(stand[index]), apart[index], pace)
    left = np.flatnonzero(stays)
    renumbered = (np.cumsum(stays) - 1).tolist()
    for name, _, _ in NODES:
        array = getattr(held, name)
        array[: len(left)] = array[left]
    pairs = [(a, b, *links[a][b]) for a in left.tolist() for b in sorted(links[a]) if a < b]
    for name, shape, kind in LINKS:
        setattr(held, name, np.zeros((max(64, len(pairs)), *shape), kind))
    for n, (a, b, seen, seconds, taken) in enumerate(pairs):
        held.sources[n], held.targets[n] = renumbered[a], renumbered[b]
        held.durations[n], held.taken[n] = seconds, taken
        held.measured[n] = math.hypot(seen[0], seen[1]), math.atan2(seen[1], seen[0]), seen[2]
    held.count, held.linked = len(left), len(pairs)
    held.current = renumbered[held.current] if held.current >= 0 else -1
    held.pairs = {(renumbered[a], renumbered[b]): n for n, (a, b, *_) in enumerate(pairs)}


def pruned(
    held: ExperienceMap,
    protected: frozenset[int],
    keep_views: Callable[[Numbers], None],
    wanted: frozenset[int] = frozenset(),
) -> tuple[dict[int, int], dict[int, int]]:
    """Prune the map, and the templates that no experience uses any more by `keep_views`.

    protected: ids that stay; wanted: ids that stay before others of their place.
    Return for the id of each experience that went the id of the one that stays where it was, if one does, and the new
    number of each template that is left.
    """
    stand = standing(held, protected, wanted)
    gone = np.flatnonzero((stand != np.arange(held.count)) & same_place(held, stand))
    heirs = dict(zip(held.ids[gone].tolist(), held.ids[stand[gone]].tolist(), strict=True))
    contract(held, stand)
    used = np.unique(held.views[: held.count])
    keep_views(used)
    held.views[: held.count] = np.searchsorted(used, held.views[: held.count])
    return heirs, {int(old): new for new, old in enumerate(used)}
