"""The paper's two composites: 780 x 460 with the pose cells, 320 x 480 without them."""

from collections.abc import Iterator, Mapping, Sequence
from math import isfinite
from typing import Any

import numpy as np

from robots.kit.contract.composites import Pixels
from robots.kit.contract.session import RobotState
from robots.kit.drivers.irat.composites.decoding import MapShown, silent, with_cells, with_map
from robots.kit.drivers.irat.composites.drawing import (
    DOCK,
    GROUND,
    INK,
    QUIET,
    draw_camera,
    draw_cells,
    draw_map,
    words,
)

GAP, BAR = 8, 30
MOST_GOALS = 10
NARROW = 500  # px; below this the pose cells are left out


class Scene:
    """A `robots.kit.contract.composites.Scene` of the iRat."""

    def __init__(self, width: int, height: int) -> None:
        self._width, self._height = width, height
        self._map, self._cells = MapShown(), silent()

    def take(self, stream: str, data: bytes, key: bool) -> None:
        """Take the next packet. Raises ValueError for one that cannot be read."""
        if stream == "map":
            self._map = with_map(self._map, data, key)
        elif stream == "cells":
            self._cells = with_cells(self._cells, data, key)

    def draw(self, picture: bytes | None, state: RobotState | None, jobs: Sequence[Mapping[str, Any]]) -> Pixels:
        """Return the composite."""
        whole: Pixels = np.full((self._height, self._width, 3), GROUND, np.uint8)
        status(whole, state)
        pose = pose_of(state)
        goals = list(goals_of(jobs, self._map))
        if self._width < NARROW:
            camera_h = (self._width - 2 * GAP) * 240 // 416
            _put(whole, draw_camera(picture, self._width - 2 * GAP, camera_h), GAP, BAR)
            top = BAR + camera_h + GAP
            _put(whole, draw_map(self._map, pose, goals, self._width - 2 * GAP, self._height - top - GAP), GAP, top)
            return whole
        left = 46 * self._width // 100
        camera_h = left * 240 // 416
        _put(whole, draw_camera(picture, left, camera_h), GAP, BAR)
        below = BAR + camera_h + GAP
        _put(whole, draw_cells(self._cells, left, self._height - below - GAP), GAP, below)
        right = self._width - left - 3 * GAP
        _put(whole, draw_map(self._map, pose, goals, right, self._height - BAR - GAP), left + 2 * GAP, BAR)
        return whole


def _put(whole: Pixels, part: Pixels, x: int, y: int) -> None:
    whole[y : y + part.shape[0], x : x + part.shape[1]] = part


def status(whole: Pixels, state: RobotState | None) -> None:
    """Write the first line: name, connection, battery and activity of the robot."""
    narrow = whole.shape[1] < NARROW
    words(whole, "iRat", GAP, 20, 0.55, INK)
    if state is None:
        words(whole, "connecting", 60, 20, colour=QUIET)
        return
    if not narrow:
        words(whole, "online", 60, 20, colour=DOCK)
    known = (("battery", ".1f", "V"), ("charge", ".0f", "%"))
    told = " ".join(f"{state.values[name]:{form}} {unit}" for name, form, unit in known if name in state.values)
    words(whole, told, 60 if narrow else 130, 20, 0.4 if narrow else 0.45, QUIET)
    words(whole, state.mode, 150 if narrow else 260, 20, 0.37 if narrow else 0.45, QUIET)


def pose_of(state: RobotState | None) -> tuple[float, float, float] | None:
    """Return x, y (m) and heading (rad) on the map, None where they are not known."""
    if state is None or not all(name in state.values for name in ("x", "y", "heading")):
        return None
    return state.values["x"], state.values["y"], state.values["heading"]


def goals_of(jobs: Sequence[Mapping[str, Any]], map_shown: MapShown) -> Iterator[tuple[int, float, float]]:
    """Yield number and place of the goals of this map, in the order of their turns.

    A goal is where its experience is by now, because the map is pulled straight; else where it was asked for.
    """
    for turn, args in enumerate(jobs[:MOST_GOALS]):
        x, y, which, experience = (args.get(name) for name in ("x", "y", "map", "experience"))
        if which != map_shown.number:
            continue
        if isinstance(experience, int | float) and 0 <= experience < 2**32:
            now = map_shown.where(np.array([int(experience)], np.int64))
            x, y = (float(now[0, 0]), float(now[0, 1])) if len(now) else (x, y)
        if isinstance(x, int | float) and isinstance(y, int | float) and isfinite(x) and isfinite(y):
            yield turn, float(x), float(y)
