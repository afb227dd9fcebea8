"""Routes over the experience map: the quickest one to a goal, and the waypoint on it to steer for (section 3.4)."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robots.kit.slam.angles import wrapped
from robots.kit.slam.experiences import ExperienceMap
from robots.kit.slam.shortest import shortest

REACHED_M = 0.1
WAYPOINT_M = 0.2
AHEAD_M = 0.6  # a waypoint is at most so far along the route: beyond, the route may be behind a wall
FINE_M = 0.02  # between the points of a route that are looked at
SHORTEST_S = 1e-3


@dataclass(frozen=True)
class Route:
    """Ids of experiences from the robot to the goal, and the time (s) that they took when they were first driven."""

    ids: tuple[int, ...]
    seconds: float

    @property
    def limit_s(self) -> float:
        """The time after which the goal is given up."""
        return 3.0 * self.seconds + 30.0


@dataclass(frozen=True)
class Guidance:
    """The next waypoint: its bearing (rad, left positive) and distance (m) from the robot. `reached`: of the goal."""

    reached: bool
    bearing: float
    distance: float
    waypoint: int
    route: Route


def index_of(graph: ExperienceMap, experience: int) -> int:
    """Return the index of an id; -1 if it is not on the map."""
    found = int(np.searchsorted(graph.ids[: graph.count], experience))
    return found if found < graph.count and graph.ids[found] == experience else -1


def plan(graph: ExperienceMap, goal: int) -> Route | None:
    """Return the quickest route from the current experience, None if the goal is not on the map or not linked."""
    at, begin, m = index_of(graph, goal), graph.current, graph.linked
    if at < 0 or begin < 0:
        return None
    links = graph.sources[:m], graph.targets[:m], graph.durations[:m]
    seconds, way = shortest(*links, graph.count, begin, at, SHORTEST_S)
    return Route(tuple(graph.ids[way].tolist()), float(seconds)) if math.isfinite(seconds) else None


class Guide:
    """Leads to one goal. It plans anew when the robot has left its route, or when a part of the route was pruned."""

    def __init__(self, goal: int) -> None:
        self.goal = goal
        self.route: Route | None = None
        self._passed = 0.0  # how much of the route lies behind, counted in its links

    def look(self, graph: ExperienceMap) -> Guidance | None:
        """Return where to steer; None if no way to the goal is known."""
        found = self._waypoint(graph) if self.route else None
        if found is None:
            self.route, self._passed = plan(graph, self.goal), 0.0
            if self.route is None:
                return None
            found = self._waypoint(graph)
        assert self.route is not None
        if found is None:  # beside the whole of the new route: begin with its first experience
            first = min(1, len(self.route.ids) - 1)
            x, y, facing = graph.poses[index_of(graph, self.route.ids[first])].tolist()
            found = first, x, y
        number, to_x, to_y = found
        x, y, facing = graph.pose()
        bearing = wrapped(math.atan2(to_y - y, to_x - x) - facing)
        return Guidance(
            self._reached(graph), bearing, math.hypot(to_x - x, to_y - y), self.route.ids[number], self.route
        )

    def _reached(self, graph: ExperienceMap) -> bool:
        apart = graph.poses[graph.current, :2] - graph.poses[index_of(graph, self.goal), :2]
        return bool(np.hypot(*apart) < REACHED_M)

    def _waypoint(self, graph: ExperienceMap) -> tuple[int, float, float] | None:
        """Trace the route back from the goal to the first point of it near the robot.

        Return the number of the route's experience that the point is at or before, and its x, y (m). Points between two
        experiences count: a link of a pruned map may be longer than the robot looks ahead, and without them the robot
        would stay for ever beside the experience that it has passed.
        """
        assert self.route is not None
        indices = np.searchsorted(graph.ids[: graph.count], self.route.ids)
        if indices[-1] >= graph.count or (graph.ids[np.minimum(indices, graph.count - 1)] != self.route.ids).any():
            return None  # an experience of it was pruned
        numbers, places = _fine(graph.poses[indices, :2])
        along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(places, axis=0).T))])
        apart = np.hypot(*(places - graph.pose()[:2]).T)
        behind = along[np.searchsorted(numbers, self._passed - 1e-9)]
        near = np.flatnonzero((along >= behind) & (along <= behind + AHEAD_M) & (apart < WAYPOINT_M))
        if not len(near):
            return None
        self._passed = float(numbers[near[np.argmin(apart[near])]])
        x, y = places[near[-1]].tolist()
        return math.ceil(numbers[near[-1]]), x, y


def _fine(places: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return points on the line through places, (n, 2), at most `FINE_M` apart: their numbers on it, and where.

    The places themselves are among them, with whole numbers.
    """
    parts = np.maximum(1, np.ceil(np.hypot(*np.diff(places, axis=0).T) / FINE_M)).astype(np.int64)
    links = np.repeat(np.arange(len(parts)), parts)
    begins = np.repeat(np.cumsum(parts) - parts, parts)
    numbers = np.append(links + (np.arange(len(links)) - begins) / parts[links], float(len(parts)))
    whole = np.arange(len(places))
    return numbers, np.column_stack([np.interp(numbers, whole, places[:, axis]) for axis in (0, 1)])
