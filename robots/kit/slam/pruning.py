"""Keeps a map small enough for days: of the experiences that stand and face alike, one stays.

Milford and Wyeth 2010 ("Persistent navigation and mapping using a biologically inspired SLAM system") keep the density
of experiences bounded: the links of one that goes are handed to the one that stays in its place, corrected by where the
map has the two. Ours are three rules. Such a link has the map's error in it, so it is measured anew when the robot goes
that way again (`ExperienceMap._arrive`). The oldest experience stays, because its links were measured; but not if it
was not recognised for long, because then the place looks otherwise now. Two experiences are one place only if a short
path over links leads from one to the other: where the map is not right yet, two places may overlap, and they stay apart
until the robot has closed the loop.
"""

import heapq
import math
from collections.abc import Callable, Iterable

import numpy as np
from numpy.typing import NDArray

from robots.kit.slam.experiences import LINKS, NODES, ExperienceMap, Pose, composed, inverted

Numbers = NDArray[np.int64]
Flags = NDArray[np.bool_]
Link = tuple[Pose, float, bool]  # where the other is seen, how long the way took (s), whether the robot measured it
Links = list[dict[int, Link]]  # for each experience, its links by the index of the other end
SHORT_M = 0.01  # a shorter link is mostly a turn


def alike(graph: ExperienceMap, protected: frozenset[int], wanted: frozenset[int]) -> list[list[int]]:
    """Return the experiences (indices) of each square and heading, the most wanted first.

    The order: protected ones, wanted ones, those visited lately and more than once, those not visited for long, new
    ones; within each of these the oldest first.
    """
    n, keys = graph.count, places(graph)
    needed, old = needs(graph, protected), stale(graph)
    rank = np.where(old, 1, np.where(graph.met[:n] > 0, 0, 2))
    chosen = np.isin(graph.ids[:n], np.array(sorted(wanted), np.int64))
    order = np.lexsort((graph.ids[:n], rank, ~chosen, ~needed, *keys.T[::-1]))
    keys = keys[order]
    return [part.tolist() for part in np.split(order, np.flatnonzero((np.diff(keys, axis=0) != 0).any(axis=1)) + 1)]


def places(graph: ExperienceMap) -> Numbers:
    """Return the square (x, y) and the heading of each experience, (count, 3)."""
    settings, poses = graph.settings, graph.poses[: graph.count]
    squares = np.floor(poses[:, :2] / settings.square_m).astype(np.int64)
    headings = np.floor(poses[:, 2] / (2 * np.pi) * settings.headings).astype(np.int64) % settings.headings
    return np.column_stack([squares, headings])


def same_place(graph: ExperienceMap, stand: Numbers) -> Flags:
    """Tell of each experience whether the one that stays for it is in the same square and has the same heading."""
    where = places(graph)
    found: Flags = (where == where[stand]).all(axis=1)
    return found


def stale(graph: ExperienceMap) -> Flags:
    """Tell of each experience whether it was not recognised for so long that its place may look otherwise now."""
    found: Flags = graph.visited[: graph.count] <= graph.arrivals - graph.settings.stale_after
    return found


def forgotten(graph: ExperienceMap, stays: frozenset[int]) -> Flags:
    """Tell of each experience whether it is old and was never recognised; `stays`: ids that do not count."""
    n = graph.count
    old = graph.visited[:n] <= graph.arrivals - graph.settings.forgotten_after
    found: Flags = old & (graph.met[:n] == 0) & ~needs(graph, stays)
    return found


def needs(graph: ExperienceMap, protected: frozenset[int]) -> Flags:
    """Tell of each experience whether it stays in any case: it is protected, or the current one."""
    needed: Flags = np.isin(graph.ids[: graph.count], np.array(sorted(protected), np.int64))
    if graph.current >= 0:
        needed[graph.current] = True
    return needed


def standing(graph: ExperienceMap, protected: frozenset[int], wanted: frozenset[int] = frozenset()) -> Numbers:
    """Return for each experience the index of the one that stays for it: its own, if it stays."""
    stand, needed, links = np.arange(graph.count), needs(graph, protected), _links(graph)
    old, leaves = stale(graph), forgotten(graph, protected | wanted)
    new = ~old & (graph.met[: graph.count] == 0)  # not met again yet: it replaces none, and no stale one replaces it
    for group in alike(graph, protected, wanted):
        stay: list[int] = []
        for index in (i for i in group if not leaves[i]):
            heirs = [heir for heir in stay if not (new[index] and old[heir])]
            heir = None if needed[index] or not heirs else _near(links, index, heirs, graph.settings.same_m)
            if heir is None:
                stay.append(index)
            else:
                stand[index] = heir[0]
    stays = np.flatnonzero(~leaves & (stand == np.arange(graph.count))).tolist()
    for index in np.flatnonzero(leaves).tolist():
        heir = _near(links, index, stays, graph.settings.same_m)
        if heir is not None:
            stand[index] = heir[0]
    return stand


def _near(links: Links, begin: int, wanted: Iterable[int], within: float) -> tuple[int, Pose] | None:
    """Return the one of `wanted` with the shortest path over links, None if none is within so many metres.

    Also returned is the pose of `begin` as seen from it, which is the sum of the measurements on the path.
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


def _links(graph: ExperienceMap) -> Links:
    found: Links = [{} for _ in range(graph.count)]
    for n in range(graph.linked):
        a, b = int(graph.sources[n]), int(graph.targets[n])
        distance, direction, facing = graph.measured[n].tolist()
        seen = (distance * math.cos(direction), distance * math.sin(direction), facing)
        seconds, taken = float(graph.durations[n]), bool(graph.taken[n])
        found[a][b] = (seen, seconds, taken)
        found[b][a] = (inverted(seen), seconds, taken)
    return found


def _pace(graph: ExperienceMap) -> float:
    """Return how long a metre takes (s): the median of all links that are no mere turn."""
    far = graph.measured[: graph.linked, 0] > SHORT_M
    paces = graph.durations[: graph.linked][far] / graph.measured[: graph.linked, 0][far]
    return float(np.median(paces)) if len(paces) else 0.0


def _merge(links: Links, gone: int, heir: int, apart: Pose, pace: float) -> None:
    """Hand the links of an experience to the one that stays, which sees it at `apart`.

    A link that gets longer by a metre takes longer by `pace` (s/m), and the other way round. Of two links between the
    same experiences the one that was there stays.
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


def contract(graph: ExperienceMap, stand: Numbers) -> None:
    """Remove each experience for which another one stays; its links are handed to that one."""
    links, stays, pace = _links(graph), stand == np.arange(graph.count), _pace(graph)
    gone = np.flatnonzero(~stays).tolist()
    apart, same = {}, same_place(graph, stand)
    for index, heir in ((index, int(stand[index])) for index in gone):
        measured = None if same[index] else _near(links, index, (heir,), graph.settings.same_m)
        apart[index] = measured[1] if measured else composed(inverted(graph.pose_of(heir)), graph.pose_of(index))
    for index in gone:
        _merge(links, index, int(stand[index]), apart[index], pace)
    left = np.flatnonzero(stays)
    renumbered = (np.cumsum(stays) - 1).tolist()
    for name, _, _ in NODES:
        array = getattr(graph, name)
        array[: len(left)] = array[left]
    pairs = [(a, b, *links[a][b]) for a in left.tolist() for b in sorted(links[a]) if a < b]
    for name, shape, kind in LINKS:
        setattr(graph, name, np.zeros((max(64, len(pairs)), *shape), kind))
    for n, (a, b, seen, seconds, taken) in enumerate(pairs):
        graph.sources[n], graph.targets[n] = renumbered[a], renumbered[b]
        graph.durations[n], graph.taken[n] = seconds, taken
        graph.measured[n] = math.hypot(seen[0], seen[1]), math.atan2(seen[1], seen[0]), seen[2]
    graph.count, graph.linked = len(left), len(pairs)
    graph.current = renumbered[graph.current] if graph.current >= 0 else -1
    graph.pairs = {(renumbered[a], renumbered[b]): n for n, (a, b, *_) in enumerate(pairs)}


def pruned(
    graph: ExperienceMap,
    protected: frozenset[int],
    keep_views: Callable[[Numbers], None],
    wanted: frozenset[int] = frozenset(),
) -> tuple[dict[int, int], dict[int, int]]:
    """Prune the map, and by `keep_views` the templates that no experience uses any more.

    protected: ids that stay; wanted: ids that stay before others of their place.
    Return for the id of each experience that went the id of the one that stays where it was, if one does, and the new
    number of each template that is left.
    """
    stand = standing(graph, protected, wanted)
    gone = np.flatnonzero((stand != np.arange(graph.count)) & same_place(graph, stand))
    heirs = dict(zip(graph.ids[gone].tolist(), graph.ids[stand[gone]].tolist(), strict=True))
    contract(graph, stand)
    used = np.unique(graph.views[: graph.count])
    keep_views(used)
    graph.views[: graph.count] = np.searchsorted(used, graph.views[: graph.count])
    return heirs, {int(old): new for new, old in enumerate(used)}
