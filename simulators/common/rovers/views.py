"""Views of a rover's surroundings: from its nose, and from above for people and tests."""

from collections.abc import Callable, Mapping

import cv2
import numpy as np
from numpy.typing import NDArray

from simulators.common.mesh import Mesh
from simulators.common.raster import Canvas, Lens, looking
from simulators.common.texture import Atlas

Floats = NDArray[np.float64]
Image = NDArray[np.uint8]
NOISE = 3  # grey levels in both directions: two pictures of the same place always differ
FINER = 2  # the still part of the view from above is drawn so many times as large, and averaged


def mount(camera: Mapping[str, float]) -> Floats:
    """Return the pose (4 x 4) of a camera in the hull's frame; the camera's axes are right, down, forward."""
    pose = np.eye(4)
    pose[:3, :3] = [[0, 0, 1], [-1, 0, 0], [0, -1, 0]]
    pose[:3, 3] = camera["ahead"], 0.0, camera["high"]
    return pose


def jpeg(picture: Image, quality: int, *options: int) -> bytes:
    """Return a picture (RGB) as JPEG; `options` are more of OpenCV's."""
    encoded, data = cv2.imencode(".jpg", picture[:, :, ::-1], [cv2.IMWRITE_JPEG_QUALITY, quality, *options])
    if not encoded:
        raise RuntimeError("the picture cannot be encoded")
    return bytes(data)


class Overhead:
    """The view from above: the still part is drawn once, the rover into it each time.

    `middle` is the place under the camera (m), `high` the camera's height (m).
    """

    def __init__(self, lens: Lens, middle: tuple[float, float], high: float, atlas: Atlas, rover: Mesh) -> None:
        self._lens, self._atlas, self._rover = lens, atlas, rover
        floor = np.array([*middle, 0.0])
        self._view = looking(np.add(floor, (0.0, -0.02, high)), floor, (0.0, 1.0, 0.0))
        self._canvas = Canvas(lens, atlas)
        self._still: Image = np.zeros((lens.height, lens.width, 3), np.uint8)

    def _draw_still(self, draw: Callable[[Canvas, Floats], None]) -> None:
        """Let `draw` draw all that stands still, as a canvas sees it through a view."""
        lens = self._lens
        fine = Canvas(Lens(lens.width * FINER, lens.height * FINER, lens.field), self._atlas)
        fine.begin()
        draw(fine, self._view)
        self._still = np.asarray(
            cv2.resize(fine.picture(), (lens.width, lens.height), interpolation=cv2.INTER_AREA), np.uint8
        )

    def _take(self, hull: Floats) -> Image:
        """Return the picture, shape (height, width, 3), with the rover at this pose (4 x 4)."""
        self._canvas.begin()
        self._canvas.draw(self._rover.in_frame(hull), self._view)
        rover = self._canvas.picture((1, 2, 3))
        return np.where(np.isfinite(self._canvas.depth())[:, :, None], rover, self._still)
