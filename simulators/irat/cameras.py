"""The robot's camera, and a view from above for people and tests; the robot never gets the second."""

from functools import cache
from math import radians

import numpy as np

from robots.kit.description import load
from simulators.common.mesh import Mesh
from simulators.common.raster import Canvas, Lens
from simulators.common.rovers import views
from simulators.common.rovers.views import NOISE, Floats, Image
from simulators.common.texture import Atlas
from simulators.irat import scenery
from simulators.irat.maze import HEIGHT_M, WIDTH_M

QUALITY = 30  # of a JPEG: about 6 kB, as the paper's
ABOVE = Lens(640, 580, radians(42))
ABOVE_M = 3.1


class Stage:
    """The visible scene, made once for all cameras; `decoys` are false markers on walls."""

    def __init__(self, with_maze: bool = True) -> None:
        self.atlas = Atlas()
        self.still, self.decoys = scenery.everything(self.atlas, with_maze)
        self.robot: Mesh = scenery.robot()


@cache
def stage(with_maze: bool = True) -> Stage:
    """Return the stage that all cameras of this process share."""
    return Stage(with_maze)


class RobotCamera:
    """The camera at the robot's nose. `width`: a narrower picture of the same view, for quick simulations."""

    def __init__(self, stage: Stage, width: int | None = None, noise: int = NOISE, seed: int = 1) -> None:
        known = load("irat")["camera"]
        width = width or known["width"]
        lens = Lens(width, round(width * known["height"] / known["width"]), known["field"])
        self._stage, self._canvas = stage, Canvas(lens, stage.atlas, noise, seed)
        self._mount = views.mount(known)

    def take(self, hull: Floats, decoy: int = 0) -> Image:
        """Return the picture, shape (height, width, 3), from a hull at this pose (4 x 4)."""
        view = np.asarray(np.linalg.inv(hull @ self._mount), np.float64)
        self._canvas.begin()
        self._canvas.draw(self._stage.still, view)
        if decoy and self._stage.decoys:
            self._canvas.draw(self._stage.decoys[decoy % len(self._stage.decoys)], view)
        return self._canvas.picture()


def jpeg(picture: Image) -> bytes:
    """Return a picture as JPEG."""
    return views.jpeg(picture, QUALITY)


class Overhead(views.Overhead):
    """See `views.Overhead`."""

    def __init__(self, stage: Stage) -> None:
        super().__init__(ABOVE, (WIDTH_M / 2, HEIGHT_M / 2), ABOVE_M, stage.atlas, stage.robot)
        self._draw_still(lambda canvas, view: canvas.draw(stage.still, view))

    def take(self, hull: Floats) -> Image:
        """Return the picture, shape (580, 640, 3), with the robot at this pose (4 x 4)."""
        return self._take(hull)
