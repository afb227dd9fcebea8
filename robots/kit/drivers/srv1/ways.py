"""Ways through the hall: from where the rover is to a place, over the nodes of its map (figure 4). Pure; m."""

from collections.abc import Sequence
from math import ceil, cos, hypot, sin, tau

from scipy.sparse import lil_matrix
from scipy.sparse.csgraph import dijkstra

from robots.kit.contract.errors import OutOfWorkspace
from robots.kit.description import load
from robots.kit.drivers.srv1.hall import Hall, hall

Place = tuple[float, float]
STEP_M = 0.05  # between two points of a line whose room is looked at
CORNER_M = 0.001  # that each corner adds to a way, so that ways with fewer corners are preferred
ASIDE_M, ASIDE_STEPS, DIRECTIONS = 0.05, 24, 24  # steps away from something that is too near, and around the rover
CORNERED = "No way leads out of where the rover seems to be: let it look around, or drive it by hand."
ROOM_M = float(load("srv1")["mission"]["room"])


def is_free(begin: Place, end: Place, floor: Hall) -> bool:
    """Tell whether the rover may drive straight from one place to another."""
    count = max(1, ceil(hypot(end[0] - begin[0], end[1] - begin[1]) / STEP_M))
    shares = (n / count for n in range(count + 1))
    return all(
        floor.distance(begin[0] + (end[0] - begin[0]) * s, begin[1] + (end[1] - begin[1]) * s) >= ROOM_M for s in shares
    )


def way(begin: Place, end: Place, floor: Hall | None = None) -> list[Place]:
    """Return the shortest way over the nodes, without its begin; straight where that is free.

    A rover that stands too near to something first goes aside from it.

    Raises:
        OutOfWorkspace: it may not be there, or no way leads there.

    """
    floor = hall() if floor is None else floor
    if not floor.distance(*end) >= ROOM_M:
        raise OutOfWorkspace("The rover cannot stand there: a wall, a showcase or an exhibit is too near.")
    if not floor.distance(*begin) >= ROOM_M:
        away = aside(begin, floor)
        return [away, *way(away, end, floor)]
    if is_free(begin, end, floor):
        return [end]
    names, places = [node.name for node in floor.nodes], [node.at for node in floor.nodes]
    links = lil_matrix((len(places) + 2, len(places) + 2))  # the last two are begin and end
    for number, node in enumerate(floor.nodes):
        for name in node.to:
            links[number, names.index(name)] = _apart(places[number], places[names.index(name)])
    first, last = len(places), len(places) + 1
    for number in (n for n, place in enumerate(places) if is_free(begin, place, floor)):
        links[first, number] = _apart(begin, places[number])
    for number in (n for n, place in enumerate(places) if is_free(place, end, floor)):
        links[number, last] = _apart(places[number], end)
    _, before = dijkstra(links.tocsr(), indices=first, return_predecessors=True)
    if before[last] < 0:
        raise OutOfWorkspace("No way leads there.")
    found, at = [end], int(before[last])
    while at != first:
        found.append(places[at])
        at = int(before[at])
    return found[::-1]


def aside(begin: Place, floor: Hall) -> Place:
    """Return the nearest place with room; on the way there the rover comes no nearer to anything than it stands.

    Raises OutOfWorkspace where there is none.
    """
    least = floor.distance(*begin) - 1e-9
    angles = [tau * direction / DIRECTIONS for direction in range(DIRECTIONS)]
    for number in range(1, ASIDE_STEPS + 1):
        free, away = [], ASIDE_M * number
        for angle in angles:
            place = begin[0] + away * cos(angle), begin[1] + away * sin(angle)
            room = floor.distance(*place)
            if room >= ROOM_M:
                return place
            if room >= least:
                free.append(angle)
        angles = free
    raise OutOfWorkspace(CORNERED)


def length(begin: Place, way: Sequence[Place]) -> float:
    """Return how long a way is (m)."""
    return sum(hypot(a[0] - b[0], a[1] - b[1]) for a, b in zip([begin, *way], way, strict=False))


def _apart(a: Place, b: Place) -> float:
    """Return the distance between two places, with the addition for a corner (m)."""
    return hypot(a[0] - b[0], a[1] - b[1]) + CORNER_M
