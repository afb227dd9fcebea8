"""The experience map: places as nodes of a graph, and what the robot measured between them as links."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robots.kit.slam.angles import wrapped
from robots.kit.slam.relaxing import relax
from robots.kit.slam.settings import MapSettings
from robots.kit.slam.shortest import shortest

Pose = tuple[float, float, float]
SURE_SD = 3.0  # standard deviations
LEAST_M = 1e-4  # of a link
START: Pose = (0.0, 0.0, math.pi / 2)  # the first experience faces up the page
Columns = tuple[tuple[str, tuple[int, ...], type], ...]
NODES: Columns = (
    ("ids", (), np.int64),
    ("poses", (3,), np.float64),
    ("views", (), np.int64),
    ("places", (3,), np.float64),
    ("visited", (), np.int64),
    ("met", (), np.int64),
    ("odometer", (3,), np.float64),
)
LINKS: Columns = (
    ("sources", (), np.int64),
    ("targets", (), np.int64),
    ("measured", (3,), np.float64),
    ("durations", (), np.float64),
    ("taken", (), np.bool_),
)


@dataclass
class Doubt:
    """Successive sightings that do not fit the map, but fit each other.

    offset: the pose by which the robot would have to be moved on the map. since: the next id at the first sighting.
    distance: of the odometer at that time (m). times: the number of sightings.
    """

    offset: Pose
    since: int
    distance: float
    times: int = 0


class ExperienceMap:
    """Experiences (index 0 to count - 1) and links (0 to linked - 1), in arrays that grow.

    ids: numbers that stay when the map is pruned. poses: x, y (m), facing (rad). views: number of the template.
    places: x, y, heading in pose cells. visited: the number of the last arrival here, of all arrivals. met: how often
    the robot came back. odometer: its count at the last visit (rad, m), and how the robot was turned against the
    experience (rad). sources, targets: indices of experiences. measured: distance (m), direction and facing (rad) of
    the target as seen from the source. durations: s. taken: the robot measured the link itself; it was not handed on
    from an experience that was pruned.
    """

    ids: NDArray[np.int64]
    poses: NDArray[np.float64]
    views: NDArray[np.int64]
    places: NDArray[np.float64]
    visited: NDArray[np.int64]
    met: NDArray[np.int64]
    odometer: NDArray[np.float64]
    sources: NDArray[np.int64]
    targets: NDArray[np.int64]
    measured: NDArray[np.float64]
    durations: NDArray[np.float64]
    taken: NDArray[np.bool_]

    def __init__(self, settings: MapSettings) -> None:
        self.settings = settings
        self.count = self.linked = self.next_id = self.arrivals = 0
        self.current = -1
        # since the current experience: the robot's x, y (m), facing (rad) in its frame; seconds, and seconds at rest
        self.since: Pose = (0.0, 0.0, 0.0)
        self.seconds = self.still = 0.0
        self.doubts: list[Doubt] = []
        self.pairs: dict[tuple[int, int], int] = {}  # the link between two experiences, the smaller index first
        self._room(NODES, 64, 0)
        self._room(LINKS, 64, 0)

    def _room(self, of: Columns, many: int, filled: int) -> None:
        for name, shape, kind in of:
            grown: NDArray[Any] = np.zeros((many, *shape), kind)
            if filled:
                grown[:filled] = getattr(self, name)[:filled]
            setattr(self, name, grown)

    def move(self, distance: float, turn: float, seconds: float) -> None:
        """Add a step of odometry: m along a circle, rad, s."""
        x, y, facing = self.since
        along = facing + turn / 2
        self.since = (x + distance * math.cos(along), y + distance * math.sin(along), wrapped(facing + turn))
        if distance or turn:
            self.still = 0.0
        else:
            self.still += seconds
        if self.still <= self.settings.still_s:
            self.seconds += seconds

    def pose(self) -> Pose:
        """Return where the robot is on the map: x, y (m), facing (rad)."""
        return composed(START if self.current < 0 else self.pose_of(self.current), self.since)

    def pose_of(self, index: int) -> Pose:
        """Return an experience's pose."""
        x, y, facing = self.poses[index]
        return float(x), float(y), float(facing)

    def create(self, view: int, place: Pose) -> int:
        """Make an experience where the robot is, link it to the current one, and make it the current one."""
        if self.count == len(self.ids):
            self._room(NODES, 2 * self.count, self.count)
        index, pose = self.count, self.pose()
        self.count += 1
        self.ids[index], self.poses[index], self.views[index], self.places[index] = self.next_id, pose, view, place
        self.next_id += 1
        self._arrive(index, (0.0, 0.0, 0.0))
        return index

    def fits(self, index: int, offset: Pose, bend_sd: float) -> bool:
        """Tell whether the robot may be at `offset` from an experience, by the map.

        Otherwise it is another place that looks alike. The map may be wrong by the drift of the odometry on the way
        over links between the two; `bend_sd`: how much the odometry bends (rad/m, standard deviation).
        """
        settings = self.settings
        apart, turned = self.off(index, offset)
        if apart <= settings.sure_m and turned <= settings.sure_rad:
            return True
        m = self.linked
        way, _ = shortest(
            self.sources[:m], self.targets[:m], self.measured[:m, 0].copy(), self.count, self.current, index, LEAST_M
        )
        way += math.hypot(*self.since[:2])
        bent = SURE_SD * bend_sd * way
        return (
            apart <= min(settings.sure_m + settings.drift * way + bent * way / 2, settings.carried_m)
            and turned <= settings.sure_rad + settings.drift * way + bent
        )

    def off(self, index: int, offset: Pose) -> tuple[float, float]:
        """Return how far (m) and turned (rad) `offset` from an experience is from where the map has the robot."""
        x, y, facing = composed(self.pose_of(index), offset)
        here = self.pose()
        return math.dist(here[:2], (x, y)), abs(wrapped(facing - here[2]))

    def refuse(self, candidates: list[tuple[int, Pose]], gone: float) -> tuple[int, Pose] | None:
        """Count a sighting that fits nowhere; return the experience to believe once enough successive sightings agree.

        found: experiences and how the robot stands against each. gone: the odometer (m). Sightings without a way
        between them count as one, and sightings that disagree come from several places that look alike. More of them
        are needed to believe that the robot was carried: that is rare, and no link would correct it later.
        """
        agreed: list[tuple[Doubt, tuple[int, Pose]]] = []
        for one in candidates:
            known = next((doubt for doubt in self.doubts if self._agrees(doubt, *one)), None)
            if known is None:
                known = Doubt(
                    composed(composed(self.pose_of(one[0]), one[1]), inverted(self.pose())), self.next_id, gone
                )
            if all(doubt is not known for doubt, _ in agreed):
                known.times += 1
                agreed.append((known, one))
        self.doubts = [doubt for doubt, _ in agreed]
        settings = self.settings
        for doubt, one in agreed:
            enough = settings.wrong_after if self.linkable(*one) else settings.carried_after
            if doubt.times >= enough and abs(gone - doubt.distance) >= settings.wrong_m:
                return one
        return None

    def _agrees(self, doubt: Doubt, index: int, offset: Pose) -> bool:
        x, y, facing = composed(self.pose_of(index), offset)
        there = composed(doubt.offset, self.pose())
        apart, turned = math.dist(there[:2], (x, y)), abs(wrapped(there[2] - facing))
        return apart <= self.settings.sure_m and turned <= self.settings.sure_rad

    def linkable(self, index: int, offset: Pose) -> bool:
        """Tell whether the map may be wrong by so much; otherwise the robot was carried to `offset` from there."""
        apart, turned = self.off(index, offset)
        return apart <= self.settings.carried_m and turned <= self.settings.carried_rad

    def meet(self, index: int, offset: Pose, link: bool = True) -> bool:
        """Come back to an experience; the robot stands at `offset` from it. Tell whether this made a new link.

        `link`: False if the robot was carried there, or its wheels slipped.
        """
        before = self.linked
        # an experience made since the first sighting that did not fit does not refute a doubt
        self.doubts = [doubt for doubt in self.doubts if link and self.ids[index] >= doubt.since]
        self._arrive(index, offset, link)
        self.met[index] += 1
        return self.linked > before

    def _arrive(self, index: int, offset: Pose, link: bool = True) -> None:
        pair = (min(self.current, index), max(self.current, index))
        if self.current >= 0 and link:
            known = self.pairs.get(pair)
            if known is None:
                if self.linked == len(self.sources):
                    self._room(LINKS, 2 * self.linked, self.linked)
                known = self.pairs[pair] = self.linked
                self.linked += 1
                self.sources[known], self.targets[known] = self.current, index
            if not self.taken[known]:  # new, or handed on with the map's error
                self._measure(known, composed(self.since, inverted(offset)))
        self.current, self.since, self.seconds, self.still = index, offset, 0.0, 0.0
        self.arrivals += 1
        self.visited[index] = self.arrivals

    def _measure(self, link: int, seen: Pose) -> None:
        """Note that the robot went over a link; `seen`: the pose of its end as seen from the current experience."""
        x, y, facing = seen if self.sources[link] == self.current else inverted(seen)
        self.measured[link] = math.hypot(x, y), math.atan2(y, x), facing
        self.durations[link], self.taken[link] = self.seconds, True

    def relax(self) -> None:
        """Let all links pull, those of the oldest experience first."""
        settings, m = self.settings, self.linked
        order = np.argsort(self.sources[:m], kind="stable")
        relax(self.poses, self.sources, self.targets, self.measured, order, settings.loops, settings.correction)


def composed(a: Pose, b: Pose) -> Pose:
    """Return the pose that is `b` as seen from `a`."""
    cos, sin = math.cos(a[2]), math.sin(a[2])
    return a[0] + cos * b[0] - sin * b[1], a[1] + sin * b[0] + cos * b[1], wrapped(a[2] + b[2])


def inverted(a: Pose) -> Pose:
    """Return the origin as seen from `a`."""
    cos, sin = math.cos(a[2]), math.sin(a[2])
    return -cos * a[0] - sin * a[1], sin * a[0] - cos * a[1], wrapped(-a[2])


def ring(apart: float, size: float) -> float:
    """Return a difference of places on a ring of cells, the short way round."""
    return (apart + size / 2) % size - size / 2
