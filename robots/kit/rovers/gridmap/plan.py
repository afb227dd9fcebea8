"""The stored map as geometry in the plane: straight walls and round things, and what a range sensor would read there.

x to the right, y up (m), angles to the left from +x (rad).
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robots.kit.rovers.gridmap.cones import circles_away, segments_away

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
Numbers = NDArray[np.intp]


@dataclass(frozen=True)
class RangeSensor:
    """A range sensor that looks ahead: where it is before the middle of the body, its reach, cone and noise (m, rad).

    It reads `far` also where nothing is nearer. `half_cone` is at most 1.5; a narrow ray has 0.01.
    """

    ahead: float
    near: float
    far: float
    half_cone: float
    noise: float


@dataclass(frozen=True)
class Plan:
    """Walls as segments (n, 4: x, y, x, y) and round things as circles (m, 3: x, y, radius), in m.

    The first are closed outlines: of the hall, and of what stands in it. `dark` (n + m) marks surfaces from which no
    infrared light comes back.
    """

    segments: Floats
    circles: Floats
    dark: Bools

    @classmethod
    def of(
        cls,
        width: float,
        depth: float,
        boxes: Iterable[tuple[float, float, float, float]] = (),
        circles: Iterable[tuple[float, float, float]] = (),
        dark: Iterable[int] = (),
    ) -> "Plan":
        """Return a rectangular hall with its corner at (0, 0).

        boxes: middle x, y and half sides along x and y; circles: middle x, y and radius (m); dark: numbers of boxes.
        """
        around = [(width / 2, depth / 2, width / 2, depth / 2), *boxes]
        sides = [side for x, y, a, b in around for side in _outline(x - a, y - b, x + a, y + b)]
        rounds = np.array(list(circles), float).reshape(-1, 3)
        marks = np.zeros(len(sides) + len(rounds), bool)
        for number in dark:
            marks[4 * number + 4 : 4 * number + 8] = True
        return cls(np.array(sides, float), rounds, marks)

    @property
    def extent(self) -> tuple[float, float, float, float]:
        """Return the least x and y and the greatest x and y (m)."""
        x, y = self.segments[:, [0, 2]], self.segments[:, [1, 3]]
        return float(x.min()), float(y.min()), float(x.max()), float(y.max())

    def holds(self, x: float, y: float) -> bool:
        """Return whether a place is inside the extent."""
        x0, y0, x1, y1 = self.extent
        return x0 <= x <= x1 and y0 <= y <= y1

    def room(self, x: Floats, y: Floats) -> Floats:
        """Return how far the nearest surface is (m), 0 inside of something or outside the hall; any shape."""
        ax, ay, bx, by = self.segments.T
        px, py = x[..., None], y[..., None]
        dx, dy = bx - ax, by - ay
        along = np.clip(((px - ax) * dx + (py - ay) * dy) / (dx * dx + dy * dy), 0.0, 1.0)
        away = np.hypot(px - ax - along * dx, py - ay - along * dy).min(-1)
        above = (ay > py) != (by > py)  # even-odd: what an odd number of outlines encloses is the hall's floor
        inside = (above & (px < ax + (py - ay) * dx / np.where(dy == 0.0, 1.0, dy))).sum(-1) % 2 == 1
        if len(self.circles):
            round_ = np.hypot(px - self.circles[:, 0], py - self.circles[:, 1]) - self.circles[:, 2]
            away = np.minimum(away, round_.min(-1))
        return np.where(inside, np.maximum(away, 0.0), 0.0)

    def nearest(self, x: Floats, y: Floats, heading: Floats, sensor: RangeSensor, light: bool = False) -> Floats:
        """Return what the sensor of a body at these poses reads without noise (m); the three broadcast.

        light: dark surfaces swallow what it sends out, and hide what is behind them.
        """
        return self.look(x, y, heading, sensor, light)[0]

    def look(
        self, x: Floats, y: Floats, heading: Floats, sensor: RangeSensor, light: bool = False
    ) -> tuple[Floats, Numbers]:
        """Return the same, and the number of the surface that is nearest: a segment, or after all of them a circle."""
        beam = _beam(x[..., None], y[..., None], heading[..., None], sensor)
        half = sensor.half_cone
        away = np.concatenate(
            [segments_away(self.segments, *beam, half), circles_away(self.circles, *beam, half)], axis=-1
        )
        number = away.argmin(-1)
        found = np.take_along_axis(away, number[..., None], -1)[..., 0]
        if light:
            found = np.where(self.dark[number], sensor.far, found)
        return np.clip(found, sensor.near, sensor.far), number

    def again(self, x: Floats, y: Floats, heading: Floats, sensor: RangeSensor, number: Numbers, light: bool) -> Floats:
        """Return what the sensor reads of one surface each, of that `number`, as if there were no other (m)."""
        beam = _beam(x, y, heading, sensor)
        count = len(self.segments)
        away = segments_away(self.segments[np.minimum(number, count - 1)], *beam, sensor.half_cone)
        if len(self.circles):
            round_ = circles_away(self.circles[np.maximum(number - count, 0)], *beam, sensor.half_cone)
            away = np.where(number < count, away, round_)
        if light:
            away = np.where(self.dark[number], sensor.far, away)
        return np.clip(away, sensor.near, sensor.far)


def _beam(x: Floats, y: Floats, heading: Floats, sensor: RangeSensor) -> tuple[Floats, Floats, Floats, Floats]:
    ahead, aside = np.cos(heading), np.sin(heading)
    return x + sensor.ahead * ahead, y + sensor.ahead * aside, ahead, aside


def _outline(x0: float, y0: float, x1: float, y1: float) -> list[tuple[float, float, float, float]]:
    corners = [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]
    return [(*a, *b) for a, b in zip(corners, [*corners[1:], corners[0]], strict=True)]
