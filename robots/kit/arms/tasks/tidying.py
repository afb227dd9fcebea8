"""Which objects are brought back to their first places, and in which order: pure.

What lies on top goes first, and a place that is taken is made free first. Where each waits for another one, an object
is put aside.
"""

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from math import degrees, hypot

import numpy as np

from robots.kit.arms.arrangement import Arrangement, NotPossible
from robots.kit.arms.chain import Matrix
from robots.kit.arms.goals import missing
from robots.kit.arms.objects import DescribedObject, ObjectTable, pose_of, yaw_of
from robots.kit.arms.solids import Solid, rests_on
from robots.kit.arms.tasks.steps import Open, Pair, PutAt

Near = tuple[float, float]  # m, rad: an object that is off its first place by less is there
STEP_M, MOST_PLACES = 0.04, 3  # between two places where an object may be put aside; how many are offered


@dataclass(frozen=True)
class Move:
    """A step by which an object comes to its first place; `aside`: it only makes room."""

    name: str
    action: PutAt | Open
    aside: bool = False


def displaced(arrangement: Arrangement, near: Near) -> tuple[str, ...]:
    """Return the known objects that are not where they are first. What hangs comes back by itself."""
    objects = arrangement.table.objects
    return tuple(
        name
        for name, placed in arrangement.places.items()
        if placed.held or (not objects[name].hangs and not _is_first(objects[name], pose_of(placed), near))
    )


def _is_first(described: DescribedObject, pose: Matrix, near: Near) -> bool:
    off = missing(described, pose, pose_of(described.first))
    return off[0] <= near[0] and off[1] <= near[1]


def moves(arrangement: Arrangement, near: Near, aside: Collection[str] = ()) -> Iterator[Move]:
    """Yield the moves of which one may come next, the best first; none where nothing can be brought nearer.

    An object in the gripper is put down before all else. What is in `aside` was put aside before, and is not again.
    """
    held, off = arrangement.held, displaced(arrangement, near)
    free = [name for name in ((held,) if held is not None else off) if _is_free(arrangement, name)]
    for name in free:
        described = arrangement.described(name)
        if described.hangs:
            yield Move(name, Open())
        elif _fits(arrangement, name, first_pose(arrangement.table, name)):
            yield Move(name, _put(described))
    for name in free:
        if name in aside or arrangement.described(name).hangs:
            continue
        if name == held or _is_in_the_way(arrangement, name, off):
            yield from (Move(name, PutAt(name, at), aside=True) for at in _places(arrangement, name))


def first_pose(table: ObjectTable, name: str) -> Matrix:
    """Return where an object stands first (4 x 4)."""
    described = table.objects[name]
    first = pose_of(described.first)
    return described.standing(first[:3, :3], float(first[0, 3]), float(first[1, 3]), table.height)


def _put(described: DescribedObject) -> PutAt:
    first = pose_of(described.first)
    x, y = (round(1000 * float(v), 3) for v in first[:2, 3])
    return PutAt(described.name, (x, y), round(degrees(yaw_of(first)), 3))


def _is_free(arrangement: Arrangement, name: str) -> bool:
    """Tell whether nothing lies on an object."""
    if arrangement.places[name].held:
        return True
    solid = arrangement.solid(name)
    return not any(rests_on(there, solid) for _, there in arrangement.lying(name))


def _fits(arrangement: Arrangement, name: str, pose: Matrix) -> bool:
    try:
        arrangement.check_place(name, pose)
    except NotPossible:
        return False
    return True


def _is_in_the_way(arrangement: Arrangement, name: str, off: Collection[str]) -> bool:
    """Tell whether an object lies on one that is to be moved, or where one belongs."""
    solid, table = arrangement.solid(name), arrangement.table
    for other in off:
        if other == name:
            continue
        first = Solid(first_pose(table, other), arrangement.described(other).solid(np.eye(4)).half)
        if rests_on(solid, arrangement.solid(other)) or _apart(solid, first) < _room(table) + first.radius:
            return True
    return False


def _places(arrangement: Arrangement, name: str) -> Iterator[Pair]:
    """Yield free places of the table (mm) for an object, where it is in nobody's way; that nearest to its own first."""
    table, described = arrangement.table, arrangement.described(name)
    solids = [there for _, there in arrangement.lying(name)]
    solids += [one.solid(first_pose(table, one.name)) for one in table.objects.values() if not one.hangs]
    first, room = first_pose(table, name), _room(table)
    (x0, y0), (x1, y1) = table.area
    grid = [(x, y) for x in np.arange(x0 + STEP_M, x1, STEP_M) for y in np.arange(y0 + STEP_M, y1, STEP_M)]
    offered = 0
    for x, y in sorted(grid, key=lambda at: hypot(at[0] - first[0, 3], at[1] - first[1, 3])):
        there = described.solid(described.standing(first[:3, :3], float(x), float(y), table.height))
        clear = all(_apart(there, other) >= room + other.radius for other in solids)
        if clear and _fits(arrangement, name, there.pose):
            yield round(1000 * float(x), 3), round(1000 * float(y), 3)
            offered += 1
            if offered == MOST_PLACES:
                return


def _room(table: ObjectTable) -> float:
    """Return how far (m) the open gripper reaches about the middle of what it puts down."""
    return max(hypot(*corner[:2]) for corner in table.fingers)


def _apart(one: Solid, other: Solid) -> float:
    return float(np.hypot(*(one.pose[:2, 3] - other.pose[:2, 3])))
