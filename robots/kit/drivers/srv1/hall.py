"""The hall that the rover watches, from `robot.toml` `[hall]`: walls, showcases, exhibits, and the nodes of its map.

Pure geometry in the plane: x to the right, y up (m); (0, 0) is a corner of the hall. Its walls are the sides of the
rectangle; a showcase is a box along the axes, an exhibit a cylinder; all of them reach the floor.
"""

from dataclasses import dataclass
from functools import cache
from math import cos, hypot, inf, sin, sqrt
from typing import Any

from robots.kit.description import load

Point = tuple[float, float]


@dataclass(frozen=True)
class Case:
    """A showcase: `half` are its half sides along x and y (m). Infrared light does not come back from a black one."""

    name: str
    at: Point
    half: Point
    high: float
    black: bool = False

    def distance(self, x: float, y: float) -> float:
        """Return how far a point is from its surface (m), 0 inside."""
        return hypot(max(abs(x - self.at[0]) - self.half[0], 0.0), max(abs(y - self.at[1]) - self.half[1], 0.0))

    def ray(self, x: float, y: float, angle: float) -> float:
        """Return how far a ray runs from a point outside until it meets the surface (m), infinite if it never does."""
        first, last = 0.0, inf
        for at, along, middle, half in zip((x, y), (cos(angle), sin(angle)), self.at, self.half, strict=True):
            if along == 0.0:
                if abs(at - middle) > half:
                    return inf
                continue
            one, other = sorted(((middle - half - at) / along, (middle + half - at) / along))
            first, last = max(first, one), min(last, other)
        return first if first <= last else inf


@dataclass(frozen=True)
class Exhibit:
    """An exhibit on the floor or on a column, as round as its `radius` (m)."""

    name: str
    at: Point
    radius: float
    high: float

    def distance(self, x: float, y: float) -> float:
        """Return how far a point is from its surface (m), 0 inside."""
        return max(hypot(x - self.at[0], y - self.at[1]) - self.radius, 0.0)

    def ray(self, x: float, y: float, angle: float) -> float:
        """Return how far a ray runs from a point outside until it meets the surface (m), infinite if it never does."""
        dx, dy = self.at[0] - x, self.at[1] - y
        along, aside = dx * cos(angle) + dy * sin(angle), dy * cos(angle) - dx * sin(angle)
        if along < 0.0 or abs(aside) > self.radius:
            return inf
        return max(along - sqrt(self.radius**2 - aside**2), 0.0)


@dataclass(frozen=True)
class Node:
    """A place of the map, and the names of those to which a straight way leads."""

    name: str
    at: Point
    to: tuple[str, ...]


@dataclass(frozen=True)
class Hall:
    """The whole hall. `home`: x, y (m) and heading (rad) of the rover at first; `tower`: where the radio tower stands.

    `beacon`: whether the tower tells the rover range and bearing.
    """

    width: float
    depth: float
    high: float
    tower: Point
    home: tuple[float, float, float]
    cases: tuple[Case, ...]
    exhibits: tuple[Exhibit, ...]
    nodes: tuple[Node, ...]
    beacon: bool = False

    @property
    def things(self) -> tuple[Case | Exhibit, ...]:
        """Return everything that stands on the floor."""
        return *self.cases, *self.exhibits

    def distance(self, x: float, y: float) -> float:
        """Return how far a point in the hall is from the nearest surface (m), 0 inside of one or outside the hall."""
        walls = max(0.0, min(x, self.width - x, y, self.depth - y))
        return min(walls, *(thing.distance(x, y) for thing in self.things))

    def ray(self, x: float, y: float, angle: float) -> tuple[float, Case | Exhibit | None]:
        """Return how far a ray from a point in the hall runs (m), and what it meets: None is a wall."""
        walls = min(_across(x, cos(angle), self.width), _across(y, sin(angle), self.depth))
        nearest = min(self.things, key=lambda thing: thing.ray(x, y, angle))
        away = nearest.ray(x, y, angle)
        return (away, nearest) if away < walls else (walls, None)


def _across(at: float, along: float, length: float) -> float:
    """Return how far it is along one axis to the end of the hall (m)."""
    if along == 0.0:
        return inf
    return (length - at) / along if along > 0 else at / -along


def read(described: dict[str, Any]) -> Hall:
    """Return the hall of a description's table `hall`. Raises KeyError, TypeError and ValueError if it is none."""
    return Hall(
        float(described["width"]), float(described["depth"]), float(described["high"]), _point(described["tower"]),
        (*_point(described["home"][:2]), float(described["home"][2])),
        tuple(
            Case(str(c["name"]), _point(c["at"]), _point(c["half"]), float(c["high"]), bool(c.get("black", False)))
            for c in described["case"]
        ),
        tuple(
            Exhibit(str(e["name"]), _point(e["at"]), float(e["radius"]), float(e["high"])) for e in described["exhibit"]
        ),
        tuple(Node(str(n["name"]), _point(n["at"]), tuple(map(str, n["to"]))) for n in described["node"]),
        bool(described.get("beacon", False)),
    )  # fmt: skip


def _point(pair: list[float]) -> Point:
    x, y = pair
    return float(x), float(y)


@cache
def hall() -> Hall:
    """Return the rover's hall."""
    return read(load("srv1")["hall"])
