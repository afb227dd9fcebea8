"""Places of the map from where the dock was seen (section 3.5): learnt while roaming, tried in turn to charge."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from robots.kit.slam.checks import bounded
from robots.kit.slam.experiences import ExperienceMap
from robots.kit.slam.routes import index_of

SURE = 3  # sightings; a place with fewer may have seen another thing that looked like the marker
AHEAD_RAD = math.radians(30)  # within this angle of the dock's axis an attempt succeeds as a rule
FARTHEST_M = 5.0
BEFORE_M = 0.6  # a robot that sees the dock from nearer has it straight ahead


@dataclass(frozen=True)
class DockPlace:
    """An experience's sightings: how many, and distance (m) and angle (rad) of the one nearest to the axis."""

    times: int
    z: float
    theta: float


class DockPlaces:
    """Dock places by id of the experience. A false marker is forgotten: no dock is seen where it is looked for."""

    def __init__(self, places: dict[int, DockPlace] | None = None) -> None:
        self.places = dict(places or {})

    def saw(self, experience: int, z: float, theta: float) -> None:
        """Remember a sighting from an experience (-1: there is none yet, so nothing is stored). Raises ValueError."""
        z = bounded("the distance of the dock in m", z, 0.0, FARTHEST_M)
        theta = bounded("the angle at the dock in rad", theta, -math.pi, math.pi)
        if experience < 0:
            return
        known = self.places.get(experience)
        if known is None or abs(theta) < abs(known.theta):
            self.places[experience] = DockPlace(known.times + 1 if known else 1, z, theta)
        else:
            self.places[experience] = replace(known, times=known.times + 1)

    def forget(self, experience: int) -> None:
        """Forget a place where the dock was looked for and not seen."""
        self.places.pop(experience, None)

    def best(self, tried: Iterable[int] = ()) -> int | None:
        """Return the most promising place that was not tried yet; None if there is none.

        Places with enough sightings come first, then those before the dock, then near ones.
        """
        left = {i: place for i, place in self.places.items() if i not in set(tried)}
        return min(left, key=lambda i: (*self._worth(left[i]), i), default=None)

    def inherit(self, heirs: Mapping[int, int]) -> None:
        """Hand the sightings of each experience that was pruned to the one that stayed in its place."""
        for old in self.places.keys() & heirs.keys():
            place, known = self.places.pop(old), self.places.get(heirs[old])
            if known is not None:
                place = replace(min(place, known, key=lambda p: abs(p.theta)), times=place.times + known.times)
            self.places[heirs[old]] = place

    def where(self, graph: ExperienceMap, ahead_m: float) -> tuple[float, float] | None:
        """Return where on the map the dock is (x, y; m), None before a few sightings from near.

        ahead_m: how far the camera is ahead of the robot's origin.
        """
        near = [(index_of(graph, i), place.z) for i, place in self.places.items() if place.z < BEFORE_M]
        seen = [(*graph.pose_of(index), z + ahead_m) for index, z in near if index >= 0]
        if len(seen) < SURE:
            return None
        x, y, facing, far = np.array(seen).T
        return float(np.median(x + far * np.cos(facing))), float(np.median(y + far * np.sin(facing)))

    @staticmethod
    def _worth(place: DockPlace) -> tuple[bool, bool, float]:
        return place.times < SURE, abs(place.theta) > AHEAD_RAD, place.z
