"""The rover's camera, and a view from above for people and tests; the rover never gets the second."""

from collections.abc import Mapping
from functools import cache
from math import radians

import cv2
import numpy as np
from numpy.typing import NDArray

from robots.kit.description import load
from robots.kit.drivers.srv1.hall import Hall, hall
from robots.kit.drivers.srv1.protocol import size_of
from simulators.common.mesh import Mesh, joined, placed
from simulators.common.raster import Canvas, Lens, looking
from simulators.common.texture import Atlas
from simulators.srv1 import scenery

Floats = NDArray[np.float64]
Image = NDArray[np.uint8]
Moved = Mapping[str, tuple[float, float]]  # showcases that are not where the description has them (m, m)
NOISE = 3  # grey levels in both directions: two pictures of the same place always differ
ABOVE = Lens(640, 440, radians(50))
ABOVE_M = 13.6
FINER = 2  # the still part of the view from above is drawn so many times as large, and averaged


class Stage:
    """The visible scene, made once for all cameras; showcases apart, because they can be moved."""

    def __init__(self, where: Hall) -> None:
        self.hall, self.atlas = where, Atlas()
        surfaces = scenery.Surfaces(self.atlas)
        still = [scenery.room(where, surfaces), *(scenery.exhibit(one, surfaces) for one in where.exhibits)]
        self.still: Mesh = joined(*still)
        self.cases: dict[str, Mesh] = {one.name: scenery.case(one, surfaces) for one in where.cases}
        self.rover: Mesh = scenery.rover()

    def draw(self, canvas: Canvas, view: Floats, moved: Moved) -> None:
        """Draw everything but the rover."""
        canvas.begin()
        canvas.draw(self.still, view)
        for name, mesh in self.cases.items():
            off = moved.get(name)
            canvas.draw(mesh, view if off is None else view @ placed(*off, 0.0))


@cache
def stage() -> Stage:
    """Return the stage of this process; nobody changes it."""
    return Stage(hall())


class RoverCamera:
    """The camera above the rover's front axle. Not thread safe."""

    def __init__(self, stage: Stage, noise: int = NOISE, seed: int = 1) -> None:
        known = load("srv1")["camera"]
        self._stage, self._noise, self._seed = stage, noise, seed
        self._field = float(known["field"])
        self._canvases: dict[int, Canvas] = {}
        # the camera's axes (right, down, forward) in the hull's frame, and its place there
        self._mount = np.eye(4)
        self._mount[:3, :3] = [[0, 0, 1], [-1, 0, 0], [0, -1, 0]]
        self._mount[:3, 3] = known["ahead"], 0.0, known["high"]

    def take(self, hull: Floats, width: int = 320, moved: Moved | None = None) -> Image:
        """Return the picture from a hull at this pose (4 x 4), in one of the four sizes. Raises ValueError: no size."""
        size = size_of(width)
        if width not in self._canvases:
            lens = Lens(size.width, size.height, self._field)
            self._canvases[width] = Canvas(lens, self._stage.atlas, self._noise, self._seed)
        canvas = self._canvases[width]
        self._stage.draw(canvas, np.asarray(np.linalg.inv(hull @ self._mount), np.float64), moved or {})
        return canvas.picture()


class Overhead:
    """The view from above, through the ceiling: the still part is drawn once, the rover into it each time."""

    def __init__(self, stage: Stage) -> None:
        self._stage = stage
        middle = np.array([stage.hall.width / 2, stage.hall.depth / 2, 0.0])
        self._view = looking(np.add(middle, (0.0, -0.02, ABOVE_M)), middle, (0.0, 1.0, 0.0))
        self._canvas = Canvas(ABOVE, stage.atlas)
        self._moved: Moved | None = None
        self._empty: Image = np.zeros((ABOVE.height, ABOVE.width, 3), np.uint8)

    def take(self, hull: Floats, moved: Moved | None = None) -> Image:
        """Return the picture, shape (440, 640, 3), with the rover at this pose (4 x 4)."""
        if self._moved != (moved or {}):
            self._moved = dict(moved or {})
            fine = Canvas(Lens(ABOVE.width * FINER, ABOVE.height * FINER, ABOVE.field), self._stage.atlas)
            self._stage.draw(fine, self._view, self._moved)
            self._empty = np.asarray(
                cv2.resize(fine.picture(), (ABOVE.width, ABOVE.height), interpolation=cv2.INTER_AREA), np.uint8
            )
        canvas = self._canvas
        canvas.begin()
        canvas.draw(self._stage.rover.in_frame(hull), self._view)
        rover = canvas.picture((1, 2, 3))
        return np.where(np.isfinite(canvas.depth())[:, :, None], rover, self._empty)
