"""The rover's camera, and a view from above for people and tests; the rover never gets the second."""

from collections.abc import Mapping
from functools import cache
from math import radians

import numpy as np

from robots.kit.description import load
from robots.kit.drivers.srv1.hall import Hall, hall
from robots.kit.drivers.srv1.protocol import size_of
from simulators.common.mesh import Mesh, joined, placed
from simulators.common.raster import Canvas, Lens
from simulators.common.rovers import views
from simulators.common.rovers.views import NOISE, Floats, Image
from simulators.common.texture import Atlas
from simulators.srv1 import scenery

Moved = Mapping[str, tuple[float, float]]  # showcases that are not where the description has them (m, m)
ABOVE = Lens(640, 440, radians(50))
ABOVE_M = 13.6


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
    """Return the stage that all cameras of this process share."""
    return Stage(hall())


class RoverCamera:
    """The camera above the rover's front axle. Not thread safe."""

    def __init__(self, stage: Stage, noise: int = NOISE, seed: int = 1) -> None:
        known = load("srv1")["camera"]
        self._stage, self._noise, self._seed = stage, noise, seed
        self._field = float(known["field"])
        self._canvases: dict[int, Canvas] = {}
        self._mount = views.mount(known)

    def take(self, hull: Floats, width: int = 320, moved: Moved | None = None) -> Image:
        """Return the picture from a hull at this pose (4 x 4), in one of the four sizes. Raises ValueError: no size."""
        size = size_of(width)
        if width not in self._canvases:
            lens = Lens(size.width, size.height, self._field)
            self._canvases[width] = Canvas(lens, self._stage.atlas, self._noise, self._seed)
        canvas = self._canvases[width]
        self._stage.draw(canvas, np.asarray(np.linalg.inv(hull @ self._mount), np.float64), moved or {})
        return canvas.picture()


class Overhead(views.Overhead):
    """The view from above, through the ceiling; see `views.Overhead`."""

    def __init__(self, stage: Stage) -> None:
        super().__init__(ABOVE, (stage.hall.width / 2, stage.hall.depth / 2), ABOVE_M, stage.atlas, stage.rover)
        self._stage = stage
        self._moved: Moved | None = None

    def take(self, hull: Floats, moved: Moved | None = None) -> Image:
        """Return the picture, shape (440, 640, 3), with the rover at this pose (4 x 4)."""
        if self._moved != (moved or {}):
            self._moved = now = dict(moved or {})
            self._draw_still(lambda canvas, view: self._stage.draw(canvas, view, now))
        return self._take(hull)
