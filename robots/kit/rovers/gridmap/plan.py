"""The stored map as geometry in the plane: straight walls and round things, and what a range sensor would read there.

x to the right, y up (m), angles to the left from +x (rad). A sensor reads the nearest point of all surfaces inside its
cone. Nothing can hide the nearest point, so no ray has to be followed: the part of each wall inside the cone is taken,
and the nearest point of that part.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from math import cos, sin, tan

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
Numbers = NDArray[np.intp]
TINY = 1e-300  # a segment along the side of a cone: it is inside or outside as a whole


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


def segments_away(segments: Floats, px: Floats, py: Floats, c: Floats, s: Floats, half_cone: float) -> Floats:
    """Return how far the part of each segment (..., 4: x, y, x, y) inside the cone is; infinite if no part is.

    Of many segments and sensors at once: the sensor's x, y, cosine and sine of its heading broadcast against the
    segments' last axis.
    """
    x, y = segments[..., 0] - px, segments[..., 1] - py
    ax, ay = x * c + y * s, y * c - x * s  # in the sensor's frame: x ahead, y left
    x, y = segments[..., 2] - segments[..., 0], segments[..., 3] - segments[..., 1]
    dx, dy = x * c + y * s, y * c - x * s
    slope = tan(half_cone)
    first, last = np.zeros_like(ax), np.ones_like(ax)
    for sign in (1.0, -1.0):  # each side of the cone: begin + u change >= 0, u from 0 to 1 along the segment
        begin, change = ax * slope + sign * ay, dx * slope + sign * dy
        change = np.where(change == 0.0, TINY, change)
        at, rises = -begin / change, change > 0.0
        first = np.where(rises, np.maximum(first, at), first)
        last = np.where(rises, last, np.minimum(last, at))
    u = np.minimum(np.maximum(-(ax * dx + ay * dy) / (x * x + y * y), first), last)
    ax, ay = ax + u * dx, ay + u * dy
    return np.where(first <= last, np.sqrt(ax * ax + ay * ay), np.inf)


def circles_away(circles: Floats, px: Floats, py: Floats, c: Floats, s: Floats, half_cone: float) -> Floats:
    """Return the same for circles (..., 3: x, y, radius): along the ray of the cone that is nearest to the middle."""
    x, y = circles[..., 0] - px, circles[..., 1] - py
    ax, ay = x * c + y * s, np.abs(y * c - x * s)
    along, aside = ax * cos(half_cone) + ay * sin(half_cone), ay * cos(half_cone) - ax * sin(half_cone)
    hit = circles[..., 2] ** 2 - aside**2
    grazed = np.where((along > 0.0) & (hit > 0.0), along - np.sqrt(np.maximum(hit, 0.0)), np.inf)
    return np.where((ax > 0.0) & (aside <= 0.0), np.hypot(ax, ay) - circles[..., 2], grazed)
