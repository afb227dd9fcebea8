"""Draws the map, the pose cells, the camera and a line of words. Pure: decoded values in, pixels out.

Colours are blue-green-red. Positions on the map are in m, x to the right and y up; headings in rad.
"""

from collections.abc import Sequence
from math import cos, floor, isfinite, pi, sin

import cv2
import numpy as np

from robots.kit.contract.composites import Pixels
from robots.kit.drivers.irat.composites.decoding import SHAPE, Levels, MapShown, Places

GROUND, FRAME, INK, QUIET = (20, 18, 16), (70, 66, 60), (235, 235, 235), (165, 160, 150)
LINK, PLACE, ROUTE, DOCK, ROBOT = (120, 112, 100), (205, 195, 175), (60, 60, 235), (90, 200, 90), (235, 190, 60)
LEAST_M, GRID_M, MARGIN = 1.0, 0.5, 14  # the part of the map that is shown grows in steps of GRID_M
MOST_DOTS = 1500
FAR_M = 1e4  # nobody's place on a map
SHIFT = 4  # bits of a pixel's fraction
FONT = cv2.FONT_HERSHEY_SIMPLEX


class View:
    """Places on a map (m) as pixels of a picture, all of it in sight and undistorted."""

    def __init__(self, places: Places, width: int, height: int) -> None:
        low = np.floor(places.min(axis=0) / GRID_M) * GRID_M if len(places) else np.zeros(2)
        high = np.ceil(places.max(axis=0) / GRID_M) * GRID_M if len(places) else np.zeros(2)
        span = np.maximum(high - low, LEAST_M)
        self.scale = float(min((width - 2 * MARGIN) / span[0], (height - 2 * MARGIN) / span[1]))
        self._middle = (low + high) / 2
        self._centre = np.array([width / 2, height / 2])

    def at(self, places: Places) -> Places:
        """Return pixels (x, y), as many as places."""
        clipped = np.clip(places, -FAR_M, FAR_M) - self._middle
        return np.asarray(self._centre + clipped * np.array([self.scale, -self.scale]), np.float64)


def fixed(pixels: Places) -> "np.ndarray[tuple[int, ...], np.dtype[np.int32]]":
    """Return pixels with their fraction, as OpenCV takes them."""
    return np.rint(np.clip(pixels, -2000, 4000) * (1 << SHIFT)).astype(np.int32)


def blank(width: int, height: int) -> Pixels:
    """Return an empty part of a composite, with a frame."""
    part: Pixels = np.full((height, width, 3), GROUND, np.uint8)
    cv2.rectangle(part, (0, 0), (width - 1, height - 1), FRAME)
    return part


def words(part: Pixels, text: str, x: int, y: int, size: float = 0.45, colour: tuple[int, int, int] = INK) -> None:
    """Write into a picture; a character that the font does not have becomes a question mark."""
    plain = text.encode("ascii", "replace").decode()[:120]
    cv2.putText(part, plain, (x, y), FONT, size, colour, 1, cv2.LINE_AA)


def draw_map(
    map_shown: MapShown, pose: tuple[float, float, float] | None, goals: Sequence[tuple[int, float, float]],
    width: int, height: int,
) -> Pixels:  # fmt: skip
    """Return the map with its route in red, the dock and places from where it was seen in green, goals, the robot.

    `pose`: x, y, heading. `goals`: the number that stands beside the x, and where.
    """
    part = blank(width, height)
    view = View(map_shown.places, width, height)
    ends = fixed(view.at(map_shown.ends().reshape(-1, 2))).reshape(-1, 2, 2)
    if len(ends):
        cv2.polylines(part, list(ends), False, LINK, 1, cv2.LINE_AA, SHIFT)
    dots = np.rint(view.at(map_shown.places)).astype(np.int64)
    inside = dots[((dots > 0) & (dots < np.array([width - 1, height - 1]))).all(axis=1)]
    part[inside[:, 1], inside[:, 0]] = PLACE
    if map_shown.dock is not None:
        x, y = np.rint(np.clip(view.at(np.array([map_shown.dock[:2]]))[0], -2000, 4000)).astype(int).tolist()
        cv2.rectangle(part, (x - 6, y - 6), (x + 6, y + 6), DOCK, 2)
    for x, y in fixed(view.at(map_shown.where(map_shown.docks[:MOST_DOTS]))).tolist():
        cv2.circle(part, (x, y), 3 << SHIFT, DOCK, cv2.FILLED, cv2.LINE_AA, SHIFT)
    route = fixed(view.at(map_shown.where(map_shown.route)))
    if len(route) > 1:
        cv2.polylines(part, [route.reshape(-1, 1, 2)], False, ROUTE, 2, cv2.LINE_AA, SHIFT)
    for number, x, y in goals:
        _goal(part, view, number, x, y)
    if pose is not None and all(map(isfinite, pose)):
        _robot(part, view, pose)
    if not len(map_shown.ids):
        words(part, "no map yet", 12, height - 12, colour=QUIET)
    return part


def _goal(part: Pixels, view: View, number: int, x: float, y: float) -> None:
    if not (isfinite(x) and isfinite(y)):
        return
    px, py = np.rint(np.clip(view.at(np.array([[x, y]]))[0], -2000, 4000)).astype(int).tolist()
    cv2.line(part, (px - 5, py - 5), (px + 5, py + 5), INK, 2, cv2.LINE_AA)
    cv2.line(part, (px - 5, py + 5), (px + 5, py - 5), INK, 2, cv2.LINE_AA)
    words(part, str(number), px + 8, py + 5, 0.4, INK)


def _robot(part: Pixels, view: View, pose: tuple[float, float, float]) -> None:
    x, y, heading = pose
    px, py = view.at(np.array([[x, y]]))[0]
    corners = [(px + r * cos(heading + a), py - r * sin(heading + a)) for r, a in ((9, 0.0), (7, 2.5), (7, -2.5))]
    cv2.fillPoly(part, [fixed(np.array(corners)).reshape(-1, 1, 2)], ROBOT, cv2.LINE_AA, SHIFT)


def draw_cells(levels: Levels, width: int, height: int) -> Pixels:
    """Return the pose cells as a box of x, y and, upwards, the heading; active ones are dots."""
    part = blank(width, height)
    around, across, _ = SHAPE
    corners = np.array([[x, y, k] for k in (0, 1) for y in (0, 1) for x in (0, 1)], np.float64)
    pixels = fixed(_oblique(corners, width, height))
    for a, b in ((0, 1), (0, 2), (1, 3), (2, 3), (4, 5), (4, 6), (5, 7), (6, 7), (0, 4), (1, 5), (2, 6), (3, 7)):
        cv2.line(part, pixels[a].tolist(), pixels[b].tolist(), FRAME, 1, cv2.LINE_AA, SHIFT)
    k, j, i = np.nonzero(levels)
    strength = levels[k, j, i]
    strongest = np.argsort(-strength.astype(np.int64), kind="stable")[:MOST_DOTS]
    drawn = strongest[np.argsort(strength[strongest], kind="stable")]  # the strongest last, on top
    cells = np.stack([i[drawn] / (across - 1), j[drawn] / (across - 1), k[drawn] / (around - 1)], axis=1)
    for (x, y), level in zip(fixed(_oblique(cells, width, height)).tolist(), strength[drawn].tolist(), strict=True):
        colour = (50, 70 + 26 * level, 60 + 27 * level)
        cv2.circle(part, (x, y), (2 + level // 3) << SHIFT, colour, cv2.FILLED, cv2.LINE_AA, SHIFT)
    return part


def _oblique(places: Places, width: int, height: int) -> Places:
    """Return the pixels of places in a cube of side 1, seen from a corner."""
    x, y, up = places[:, 0], places[:, 1], places[:, 2]
    side = min(width / 1.9, height / 1.75)
    across = (x - y) * cos(pi / 6)
    down = (x + y) * sin(pi / 6) - up * 0.72
    return np.stack([width / 2 + across * side, height * 0.5 + (down - 0.14) * side], axis=1)


def draw_camera(jpeg: bytes | None, width: int, height: int) -> Pixels:
    """Return the robot's picture, whole and undistorted; words where there is none."""
    part = blank(width, height)
    try:
        found = cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR) if jpeg else None
    except cv2.error:
        found = None
    if found is None or found.ndim != 3:
        words(part, "no picture now", 12, height - 12, colour=QUIET)
        return part
    rows, columns = found.shape[:2]
    scale = min(width / columns, height / rows)
    w, h = max(1, floor(columns * scale)), max(1, floor(rows * scale))
    left, top = (width - w) // 2, (height - h) // 2
    part[top : top + h, left : left + w] = cv2.resize(found, (w, h), interpolation=cv2.INTER_AREA)
    return part
