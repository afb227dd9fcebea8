"""The stored map as geometry in the plane: straight walls and round things, and what a range sensor would read there.

x to the right, y up (m), angles to the left from +x (rad). What a cone reads is its nearest surface, and nothing hides
the nearest, so that no ray has to be followed: of each wall the part inside the cone is taken, and its nearest point.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from math import cos, sin, tan

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
TINY = 1e-12


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

        boxes: middle x, y and half sides along x and y (m); circles: middle x, y and radius (m); dark: numbers of boxes.
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
        """Return what the sensor of a body at these poses reads without noise (m); the three are of one shape.

        light: dark surfaces swallow what it sends out, and hide what is behind them.
        """
        ahead, aside = np.cos(heading), np.sin(heading)
        px, py = x + sensor.ahead * ahead, y + sensor.ahead * aside
        away = np.concatenate(
            [_segments(self.segments, px, py, ahead, aside, sensor), _circles(self.circles, px, py, ahead, aside, sensor)],
            axis=-1,
        )  # fmt: skip
        found = away.min(-1)
        if light and self.dark.any():
            found = np.where(away[..., self.dark].min(-1) <= found, sensor.far, found)
        return np.clip(found, sensor.near, sensor.far)


def _outline(x0: float, y0: float, x1: float, y1: float) -> list[tuple[float, float, float, float]]:
    corners = [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]
    return [(*a, *b) for a, b in zip(corners, [*corners[1:], corners[0]], strict=True)]


def _segments(segments: Floats, px: Floats, py: Floats, c: Floats, s: Floats, sensor: RangeSensor) -> Floats:
    """Return the distance of each segment's part inside the cone, in the sensor's frame; infinite if none is."""
    px, py, c, s = px[..., None], py[..., None], c[..., None], s[..., None]
    x, y = segments[:, 0] - px, segments[:, 1] - py
    ax, ay = x * c + y * s, y * c - x * s
    x, y = segments[:, 2] - segments[:, 0], segments[:, 3] - segments[:, 1]
    dx, dy = x * c + y * s, y * c - x * s
    slope = tan(sensor.half_cone)
    # both sides of the cone: f(begin) + u (f(end) - f(begin)) >= 0
    first, last = np.zeros_like(ax), np.ones_like(ax)
    for sign in (1.0, -1.0):
        begin, change = ax * slope + sign * ay, dx * slope + sign * dy
        change = np.where(np.abs(change) < TINY, TINY, change)
        at = -begin / change
        rises = change > 0.0
        first = np.where(rises, np.maximum(first, at), first)
        last = np.where(rises, last, np.minimum(last, at))
    u = np.minimum(np.maximum(-(ax * dx + ay * dy) / (x * x + y * y), first), last)
    return np.where(first <= last, np.sqrt((ax + u * dx) ** 2 + (ay + u * dy) ** 2), np.inf)


def _circles(circles: Floats, px: Floats, py: Floats, c: Floats, s: Floats, sensor: RangeSensor) -> Floats:
    """Return the same for circles: along the ray of the cone that is nearest to the middle."""
    x, y = circles[:, 0] - px[..., None], circles[:, 1] - py[..., None]
    ax, ay = x * c[..., None] + y * s[..., None], np.abs(y * c[..., None] - x * s[..., None])
    edge = cos(sensor.half_cone), sin(sensor.half_cone)
    along, aside = ax * edge[0] + ay * edge[1], ay * edge[0] - ax * edge[1]
    hit = np.where((along > 0.0) & (aside < circles[:, 2]), circles[:, 2] ** 2 - aside**2, np.nan)
    grazed = np.nan_to_num(along - np.sqrt(hit), nan=np.inf)
    return np.where((ax > 0.0) & (aside <= 0.0), np.hypot(ax, ay) - circles[:, 2], grazed)
