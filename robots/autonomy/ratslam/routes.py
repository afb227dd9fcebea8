"""Ways over the experience map: the quickest one to a goal, and the waypoint on it to steer for (section 3.4)."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robots.autonomy.ratslam.angles import wrapped
from robots.autonomy.ratslam.checks import bounded
from robots.autonomy.ratslam.experiences import ExperienceMap
from robots.autonomy.ratslam.shortest import shortest

CLICK_M = 0.1  # a click counts within this of an experience
REACHED_M = 0.1
WAYPOINT_M = 0.2
AHEAD_M = 0.6  # a waypoint is at most so far along the route: beyond, the route may be behind a wall
FARTHEST_M = 1000.0
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
    """Where to steer. bearing (rad, left positive) and distance (m) of the waypoint from the robot."""

    reached: bool
    bearing: float
    distance: float
    waypoint: int
    route: Route


def index_of(held: ExperienceMap, experience: int) -> int:
    """Return the index of an id; -1 if it is not on the map."""
    found = int(np.searchsorted(held.ids[: held.count], experience))
    return found if found < held.count and held.ids[found] == experience else -1


def nearest(held: ExperienceMap, x: float, y: float, within: float = CLICK_M) -> int | None:
    """Return the id of the experience nearest to a place (m), None if none is within. Raises ValueError."""
    x = bounded("x in m", x, -FARTHEST_M, FARTHEST_M)
    y = bounded("y in m", y, -FARTHEST_M, FARTHEST_M)
    if not held.count:
        return None
    apart = np.hypot(*(held.poses[: held.count, :2] - (x, y)).T)
    found = int(np.argmin(apart))
    return int(held.ids[found]) if apart[found] <= within else None


def plan(held: ExperienceMap, goal: int) -> Route | None:
    """Return the quickest route from the current experience, None if the goal is not on the map or not linked."""
    at, begin, m = index_of(held, goal), held.current, held.linked
    if at < 0 or begin < 0:
        return None
    seconds, way = shortest(held.sources[:m], held.targets[:m], held.durations[:m], held.count, begin, at, SHORTEST_S)
    return Route(tuple(held.ids[way].tolist()), float(seconds)) if math.isfinite(seconds) else None


class Guide:
    """Leads to one goal. It plans anew when the robot has left its route, or the route the map."""

    def __init__(self, goal: int) -> None:
        self.goal = goal
        self.route: Route | None = None
        self._passed = 0  # how many experiences of the route lie behind

    def look(self, held: ExperienceMap) -> Guidance | None:
        """Return where to steer; None if no way to the goal is known."""
        found = self._waypoint(held) if self.route else None
        if found is None:
            self.route, self._passed = plan(held, self.goal), 0
            if self.route is None:
                return None
            found = self._waypoint(held)
        assert self.route is not None
        if found is None:  # beside every experience of the new route: begin with its first
            found = min(1, len(self.route.ids) - 1)
        index = index_of(held, self.route.ids[found])
        x, y, facing = held.pose()
        dx, dy = float(held.poses[index, 0]) - x, float(held.poses[index, 1]) - y
        bearing = wrapped(math.atan2(dy, dx) - facing)
        return Guidance(self._reached(held), bearing, math.hypot(dx, dy), self.route.ids[found], self.route)

    def _reached(self, held: ExperienceMap) -> bool:
        apart = held.poses[held.current, :2] - held.poses[index_of(held, self.goal), :2]
        return bool(np.hypot(*apart) < REACHED_M)

    def _waypoint(self, held: ExperienceMap) -> int | None:
        """Trace the route back from the goal to the first experience near the robot; return its number on the route."""
        assert self.route is not None
        indices = np.searchsorted(held.ids[: held.count], self.route.ids)
        if indices[-1] >= held.count or (held.ids[np.minimum(indices, held.count - 1)] != self.route.ids).any():
            return None  # an experience of it was pruned
        places: NDArray[np.float64] = held.poses[indices, :2]
        along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(places, axis=0).T))])
        apart = np.hypot(*(places - held.pose()[:2]).T)
        ahead = (np.arange(len(along)) >= self._passed) & (along <= along[self._passed] + AHEAD_M)
        near = np.flatnonzero(ahead & (apart < WAYPOINT_M))
        if not len(near):
            return None
        self._passed = int(near[np.argmin(apart[near])])
        return int(near[-1])
