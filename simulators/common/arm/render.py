"""Pictures of the scene: by MuJoCo's renderer if the machine has one, otherwise by ray casting.

The ray camera needs only MuJoCo: one ray per pixel, one more from the lamp for its shadow, shaded by Lambert's law;
30 to 90 ms for 320 x 240 on one core, so a scene at rest is rendered once (see `cameras`).
"""

import logging
import os
from concurrent.futures import ThreadPoolExecutor
from typing import Protocol

import mujoco
import numpy as np
from numpy.typing import NDArray

from simulators.common.arm.scene import HIDDEN, JUDGE, LAMP, SKY

Picture = NDArray[np.uint8]
AMBIENT, DIFFUSE, SHADED = 0.42, 0.66, 0.05
log = logging.getLogger(__name__)


class Renderer(Protocol):
    """Takes pictures of shape (height, width, 3)."""

    def take(self, data: mujoco.MjData, camera: str) -> Picture:
        """Return the named camera's picture."""


class RayRenderer:
    """One ray a pixel, on the CPU, with no graphics library."""

    def __init__(self, model: mujoco.MjModel, width: int, height: int) -> None:
        self._model, self._shape = model, (height, width)
        self._groups = np.ones(6, dtype=np.uint8)
        self._groups[[HIDDEN, JUDGE]] = 0
        self._rays: dict[str, NDArray[np.float64]] = {}
        count = width * height
        self._geom = np.empty(count, dtype=np.int32)
        self._distance = np.empty(count)
        self._normal = np.empty(3 * count)
        self._shadow = np.empty(count)
        self._colours = np.array(model.geom_rgba[:, :3], dtype=np.float64) * 255

    def _through(self, camera: str) -> NDArray[np.float64]:
        """Return the rays (n, 3) in the camera's frame."""
        if camera not in self._rays:
            height, width = self._shape
            half = np.tan(np.radians(self._model.camera(camera).fovy[0]) / 2)
            rows, columns = np.mgrid[0:height, 0:width]
            x = (columns + 0.5 - width / 2) / (height / 2) * half
            y = -(rows + 0.5 - height / 2) / (height / 2) * half
            rays = np.stack([x, y, -np.ones_like(x)], axis=-1).reshape(-1, 3)
            self._rays[camera] = rays / np.linalg.norm(rays, axis=1, keepdims=True)
        return self._rays[camera]

    def take(self, data: mujoco.MjData, camera: str) -> Picture:
        """See Renderer."""
        model, count = self._model, len(self._geom)
        camera_at = np.array(data.camera(camera).xpos)
        rays = self._through(camera) @ np.array(data.camera(camera).xmat).reshape(3, 3).T
        mujoco.mj_multiRay(model, data, camera_at, np.ascontiguousarray(rays).reshape(-1), self._groups, True, -1,
                           self._geom, self._distance, self._normal, count, 10.0)  # fmt: skip
        hit = self._geom >= 0
        points = camera_at + rays * self._distance[:, None]
        lamp = np.array(LAMP)
        way = points - lamp
        far = np.linalg.norm(way, axis=1)
        way /= np.where(far > 0, far, 1.0)[:, None]
        behind = np.empty(count, dtype=np.int32)
        mujoco.mj_multiRay(model, data, lamp, np.ascontiguousarray(way).reshape(-1), self._groups, True, -1, behind,
                           self._shadow, None, count, 10.0)  # fmt: skip
        lit = (self._shadow < 0) | (self._shadow > far - 0.004)
        normals = self._normal.reshape(-1, 3)
        facing = np.clip(-np.einsum("ij,ij->i", normals, way), 0.0, 1.0)
        light = AMBIENT + DIFFUSE * facing * np.where(lit, 1.0, SHADED)
        colours = np.where(
            hit[:, None],
            self._colours[self._geom] * light[:, None] * self._grain(points),
            np.array(SKY, dtype=np.float64),
        )
        return np.clip(colours, 0, 255).astype(np.uint8).reshape(*self._shape, 3)

    def _grain(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return a light pattern of planks on the shape called "table", which shows perspective."""
        table = self._geom == self._model.geom("table").id
        planks = 1.0 - 0.05 * (np.floor(points[:, 1] / 0.12) % 2) - 0.03 * (np.floor(points[:, 0] / 0.3) % 2)
        grain: NDArray[np.float64] = np.where(table, planks, 1.0)[:, None]
        return grain


class LibraryRenderer:
    """MuJoCo's renderer, through OSMesa or EGL, in its own thread, because an EGL context belongs to one thread."""

    def __init__(self, model: mujoco.MjModel, width: int, height: int) -> None:
        self._thread = ThreadPoolExecutor(1, "render")
        self._renderer = self._thread.submit(mujoco.Renderer, model, height, width).result()

    def take(self, data: mujoco.MjData, camera: str) -> Picture:
        """See Renderer."""
        return self._thread.submit(self._take, data, camera).result()

    def _take(self, data: mujoco.MjData, camera: str) -> Picture:
        self._renderer.update_scene(data, camera=camera)
        return np.asarray(self._renderer.render())


def make(model: mujoco.MjModel, width: int, height: int) -> Renderer:
    """Return the best renderer that works here, and log which."""
    if os.environ.get("MUJOCO_GL", "disable") != "disable":
        try:
            made = LibraryRenderer(model, width, height)
            log.info("cameras by MuJoCo's renderer (%s)", os.environ["MUJOCO_GL"])
            return made
        except Exception as error:  # noqa: BLE001 - whatever a graphics library raises
            log.warning("MuJoCo's renderer does not work here: %s", error)
    log.info("cameras by rays")
    return RayRenderer(model, width, height)
