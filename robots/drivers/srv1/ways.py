"""Ways through the hall: from where the rover is to a place, over the nodes of its map (figure 4). Pure; m."""

from collections.abc import Mapping, Sequence
from math import hypot
from typing import Any

from scipy.sparse import lil_matrix
from scipy.sparse.csgraph import dijkstra

from robots.contract.errors import OutOfWorkspace
from robots.description import load

Place = tuple[float, float]
STEP_M = 0.05  # between two points of a line whose room is looked at
ROOM_M = 0.30  # that the middle of the rover leaves to cases, exhibits and walls


def room(place: Place, hall: Mapping[str, Any]) -> float:
    """Return how far the nearest wall, case or exhibit is; below 0 inside of one."""
    x, y = place
    found = [x, y, hall["width"] - x, hall["depth"] - y]
    for case in hall.get("case", ()):
        ahead, aside = (abs(at - to) - half for at, to, half in zip(place, case["at"], case["half"], strict=True))
        found.append(hypot(max(ahead, 0.0), max(aside, 0.0)) + min(max(ahead, aside), 0.0))
    found += (hypot(x - one["at"][0], y - one["at"][1]) - one["radius"] for one in hall.get("exhibit", ()))
    return min(found)


def is_free(begin: Place, end: Place, hall: Mapping[str, Any]) -> bool:
    """Tell whether the rover may drive straight from one place to another."""
    count = max(1, round(hypot(end[0] - begin[0], end[1] - begin[1]) / STEP_M))
    shares = (n / count for n in range(count + 1))
    return all(
        room((begin[0] + (end[0] - begin[0]) * s, begin[1] + (end[1] - begin[1]) * s), hall) >= ROOM_M for s in shares
    )


def way(begin: Place, end: Place, hall: Mapping[str, Any] | None = None) -> list[Place]:
    """Return the shortest way over the nodes, without its begin; straight where that is free.

    A rover that stands too near to something first goes to the nearest node.

    Raises:
        OutOfWorkspace: it may not be there, or no way leads there.

    """
    hall = load("srv1")["hall"] if hall is None else hall
    if not room(end, hall) >= ROOM_M:
        raise OutOfWorkspace("The rover cannot stand there: a wall, a showcase or an exhibit is too near.")
    if is_free(begin, end, hall):
        return [end]
    names = [node["name"] for node in hall["node"]]
    places: list[Place] = [(float(node["at"][0]), float(node["at"][1])) for node in hall["node"]]
    links = lil_matrix((len(places) + 2, len(places) + 2))  # before the last two: begin, then end
    for number, node in enumerate(hall["node"]):
        for name in node["to"]:
            links[number, names.index(name)] = _apart(places[number], places[names.index(name)])
    first, last = len(places), len(places) + 1
    reached = [n for n, place in enumerate(places) if is_free(begin, place, hall)] or [_nearest(begin, places)]
    for number in reached:
        links[first, number] = _apart(begin, places[number])
    for number in (n for n, place in enumerate(places) if is_free(place, end, hall)):
        links[number, last] = _apart(places[number], end)
    _, before = dijkstra(links.tocsr(), indices=first, return_predecessors=True)
    if before[last] < 0:
        raise OutOfWorkspace("No way leads there.")
    found, at = [end], int(before[last])
    while at != first:
        found.append(places[at])
        at = int(before[at])
    return found[::-1]


def length(begin: Place, way: Sequence[Place]) -> float:
    """Return how long a way is (m)."""
    return sum(_apart(a, b) for a, b in zip([begin, *way], way, strict=False))


def _apart(a: Place, b: Place) -> float:
    return max(hypot(a[0] - b[0], a[1] - b[1]), 1e-6)  # a link of length 0 is none in a sparse matrix


def _nearest(begin: Place, places: Sequence[Place]) -> int:
    return min(range(len(places)), key=lambda n: _apart(begin, places[n]))
