"""The robot's camera, and a view from above for people and tests; the robot never gets the second."""

from functools import cache
from math import radians

import cv2
import numpy as np
from numpy.typing import NDArray

from robots.kit.description import load
from simulators.common.mesh import Mesh, joined
from simulators.common.raster import Canvas, Lens, looking
from simulators.common.texture import Atlas
from simulators.irat import scenery
from simulators.irat.maze import HEIGHT_M, WIDTH_M

Floats = NDArray[np.float64]
Image = NDArray[np.uint8]
NOISE = 3  # grey levels in both directions: two pictures of the same place always differ
QUALITY = 30  # of a JPEG: about 6 kB, as the paper's
ABOVE = Lens(640, 580, radians(42))
ABOVE_M = 3.1
FINER = 2  # the still part of the view from above is drawn so many times as large, and averaged


class Stage:
    """The visible scene, made once for all cameras; `decoys` are false markers on walls."""

    def __init__(self, with_maze: bool = True) -> None:
        self.atlas = Atlas()
        self.still, self.decoys = scenery.everything(self.atlas, with_maze)
        self.robot: Mesh = scenery.robot()


@cache
def stage(with_maze: bool = True) -> Stage:
    """Return the stage of this process; nobody changes it."""
    return Stage(with_maze)


class RobotCamera:
    """The camera at the robot's nose. `width`: a narrower picture of the same view, for quick simulations."""

    def __init__(self, stage: Stage, width: int | None = None, noise: int = NOISE, seed: int = 1) -> None:
        known = load("irat")["camera"]
        width = width or known["width"]
        lens = Lens(width, round(width * known["height"] / known["width"]), known["field"])
        self._stage, self._canvas = stage, Canvas(lens, stage.atlas, noise, seed)
        # the camera's axes (right, down, forward) in the hull's frame, and its place there
        self._mount = np.eye(4)
        self._mount[:3, :3] = [[0, 0, 1], [-1, 0, 0], [0, -1, 0]]
        self._mount[:3, 3] = known["ahead"], 0.0, known["high"]

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
    done, data = cv2.imencode(".jpg", picture[:, :, ::-1], [cv2.IMWRITE_JPEG_QUALITY, QUALITY])
    if not done:
        raise RuntimeError("the picture cannot be encoded")
    return bytes(data)


class Overhead:
    """The view from above: the still part is drawn once, the robot into it each time."""

    def __init__(self, stage: Stage) -> None:
        self._stage = stage
        middle = np.array([WIDTH_M / 2, HEIGHT_M / 2, 0.0])
        self._view = looking(np.add(middle, (0.0, -0.02, ABOVE_M)), middle, (0.0, 1.0, 0.0))
        fine = Canvas(Lens(ABOVE.width * FINER, ABOVE.height * FINER, ABOVE.field), stage.atlas)
        fine.begin()
        fine.draw(stage.still, self._view)
        self._empty = cv2.resize(fine.picture(), (ABOVE.width, ABOVE.height), interpolation=cv2.INTER_AREA)
        self._canvas = Canvas(ABOVE, stage.atlas)

    def take(self, hull: Floats) -> Image:
        """Return the picture, shape (580, 640, 3), with the robot at this pose (4 x 4)."""
        canvas = self._canvas
        canvas.begin()
        canvas.draw(joined(self._stage.robot).in_frame(hull), self._view)
        robot = canvas.picture((1, 2, 3))
        return np.where(np.isfinite(canvas.depth())[:, :, None], robot, self._empty)
