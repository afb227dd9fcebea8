"""The maze: the letters U and Q, one over the other, as corridors between walls of foam (section 6.1 of the paper).

About 2.1 x 1.9 m on a black board; x to the right, y up, in m, the origin in the lower left corner. The corridors run
along `STROKES`; the walls are what surrounds them, and a column of blocks stands where three corridors meet. The dock
is in the top left end of the U. Its frame has its origin on the floor below the markers; its x axis points out of it.
"""

from dataclasses import dataclass
from functools import cache
from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
WIDTH_M, HEIGHT_M = 2.1, 1.9
HALF_M = 0.15  # of a corridor
WALL_M, WALL_HIGH_M = 0.03, 0.15
DOCK = (0.2, 1.80, -np.pi / 2)  # m, m, rad
COLUMN = (1.38, 0.73, 0.04)  # of blocks, in the open place of the Q: x, y, half its side (m)
BOARD = (-0.12, -0.12, WIDTH_M + 0.12, HEIGHT_M + 0.12)  # under the maze: x, y, x, y (m)
OPEN_FLOOR = (DOCK[0] - 2.0, DOCK[1] - 2.6, DOCK[0] + 2.0, DOCK[1] + 0.4)  # the board without a maze
GRAIN_M = 0.001  # a pixel of the plan from which the walls are traced
ROUGH_M = 0.004  # tolerance of the traced walls


def _arc(x: float, y: float, radius: float, begin_deg: float, end_deg: float) -> Floats:
    angles = np.radians(np.arange(begin_deg, end_deg + 1, 6))
    return np.column_stack([x + radius * np.cos(angles), y + radius * np.sin(angles)])


STROKES: tuple[Floats, ...] = (
    np.concatenate([[(0.2, 1.715)], _arc(0.70, 0.70, 0.50, 180, 360), [(1.2, 1.68)]]),  # U
    _arc(1.35, 1.12, 0.57, 0, 360),  # Q
    np.array([(1.2, 1.12), (1.90, 0.27)]),  # its tail
)


@dataclass(frozen=True)
class Wall:
    """A piece of wall: both ends of its face (m), the free side on its left, and the same ends at its back."""

    begin: tuple[float, float]
    end: tuple[float, float]
    back_begin: tuple[float, float]
    back_end: tuple[float, float]

    @property
    def length(self) -> float:
        """Return the length of the face (m)."""
        return float(np.hypot(self.end[0] - self.begin[0], self.end[1] - self.begin[1]))


def off_centre(x: float, y: float) -> float:
    """Return the distance from the nearest corridor's centre line (m); below `HALF_M` the place is free."""
    return min(_to_stroke(np.array([x, y]), stroke) for stroke in STROKES)


def _to_stroke(place: Floats, stroke: Floats) -> float:
    begins, along = stroke[:-1], np.diff(stroke, axis=0)
    share = np.clip(np.einsum("ij,ij->i", place - begins, along) / np.einsum("ij,ij->i", along, along), 0, 1)
    return float(np.linalg.norm(begins + share[:, None] * along - place, axis=1).min())


def along_corridors(every_m: float) -> Floats:
    """Return places on the centre lines and the heading there, shape (n, 3): m, m, rad."""
    places = []
    for stroke in STROKES:
        for a, b in pairwise(stroke):
            length = float(np.linalg.norm(b - a))
            heading = float(np.arctan2(*(b - a)[::-1]))
            places += [(*(a + (b - a) * s / length), heading) for s in np.arange(0.0, length, every_m)]
    return np.array(places)


@cache
def walls() -> tuple[tuple[Wall, ...], ...]:
    """Return the closed rows of walls around the corridors: the outer one, then those of the islands."""
    plan = np.zeros((round(HEIGHT_M / GRAIN_M), round(WIDTH_M / GRAIN_M)), np.uint8)
    for stroke in STROKES:
        pixels = np.round(stroke / GRAIN_M).astype(np.int32)
        cv2.polylines(plan, [pixels], False, 255, round(2 * HALF_M / GRAIN_M))
        for end in (pixels[0], pixels[-1]):
            cv2.circle(plan, (int(end[0]), int(end[1])), round(HALF_M / GRAIN_M), 255, -1)
    found, _ = cv2.findContours(plan, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)
    traced = [cv2.approxPolyDP(contour, ROUGH_M / GRAIN_M, True)[:, 0, :] for contour in found]
    rows = [np.asarray(outline * GRAIN_M, np.float64) for outline in traced]
    rows.sort(key=lambda row: -abs(_area(row)))
    return tuple(_row(row, inside=number == 0) for number, row in enumerate(rows))


def _area(row: Floats) -> float:
    x, y = row.T
    return float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2


def _row(outline: Floats, inside: bool) -> tuple[Wall, ...]:
    """Return a closed row of walls; the corridor is `inside` the outline, or around it."""
    if (_area(outline) > 0) != inside:
        outline = outline[::-1]
    back = _pushed(outline, -WALL_M)
    count = len(outline)
    return tuple(
        Wall(_pair(outline[i]), _pair(outline[(i + 1) % count]), _pair(back[i]), _pair(back[(i + 1) % count]))
        for i in range(count)
    )


def _pair(place: Floats) -> tuple[float, float]:
    return float(place[0]), float(place[1])


def _pushed(outline: Floats, distance: float) -> Floats:
    """Return the outline moved to its left by `distance` (m), with mitred corners."""
    before, after = outline - np.roll(outline, 1, axis=0), np.roll(outline, -1, axis=0) - outline
    normals = [np.column_stack([-d[:, 1], d[:, 0]]) / np.linalg.norm(d, axis=1)[:, None] for d in (before, after)]
    middle = normals[0] + normals[1]
    middle /= np.linalg.norm(middle, axis=1)[:, None]
    stretch = np.clip(np.einsum("ij,ij->i", middle, normals[0]), 0.5, 1.0)
    return np.asarray(outline + middle * (distance / stretch)[:, None])
