"""Pictures of the cell by the rasteriser of triangles, twice as fine and averaged."""

import cv2
import mujoco
import numpy as np

from robots.kit.description import load
from simulators.common.arm.cameras import PLACES
from simulators.common.arm.render import Picture
from simulators.common.arm.scene import SKY
from simulators.common.mesh import SUN, Mesh, joined
from simulators.common.raster import Canvas, Lens, looking
from simulators.common.texture import Atlas
from simulators.puma import rod, scenery
from simulators.puma.cell import DRIVER, PLATE, Floats, bearers, plate_place
from simulators.puma.scene import TABLE_M

FINER = 2
LOW_M = 0.35  # a body whose middle is higher throws no shadow on the plate


class RasterRenderer:
    """Draws the cell as a camera of the description sees it; see `simulators.common.arm.render.Renderer`."""

    def __init__(self, model: mujoco.MjModel, width: int, height: int) -> None:
        self._model, self._size, atlas = model, (width, height), Atlas()
        still, self._table = scenery.surroundings(atlas)
        still = joined(still, scenery.plate().lit(np.eye(3)))
        self._shapes = {model.body(name).id: shape for name, shape in scenery.moving(model, atlas).items()}
        self._last: dict[int, tuple[bytes, list[Mesh]]] = {}
        self._views = {}
        for view in load(DRIVER)["view"]:
            lens = Lens(width * FINER, height * FINER, float(np.radians(view["field_deg"])))
            towards = looking(np.array(view["place"]), np.array(view["at"]))
            canvas = Canvas(lens, atlas)
            canvas.begin()
            canvas.draw(still, towards)
            canvas.keep(SKY)
            self._views[view["name"]] = canvas, towards
        x, y, _ = plate_place()
        (one,) = (bearer for bearer in bearers() if bearer.name == PLATE)
        self._around = np.array([x, y]) - one.half[:2], np.array([x, y]) + one.half[:2], 2 * one.half[2]

    def take(self, data: mujoco.MjData, camera: str) -> Picture:
        """Return the named camera's picture, of shape (height, width, 3)."""
        canvas, view = self._views[camera]
        canvas.begin()
        for body in self._shapes:
            for mesh in self._drawn(body, data):
                canvas.draw(mesh, view)
        for mesh in self._threads(data):
            canvas.draw(mesh, view)
        return np.asarray(cv2.resize(canvas.picture(), self._size, interpolation=cv2.INTER_AREA), np.uint8)

    def _drawn(self, body: int, data: mujoco.MjData) -> list[Mesh]:
        """Return a body with its shadows, in the world's frame; the same as last time if it has not moved."""
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = data.xmat[body].reshape(3, 3), data.xpos[body]
        key = pose.round(PLACES).tobytes()
        known, meshes = self._last.get(body, (b"", []))
        if key == known:
            return meshes
        mesh, edge = self._shapes[body].lit(pose[:3, :3]).in_frame(pose), np.full(2, TABLE_M)
        meshes = [mesh, scenery.shadow(mesh, SUN, 0.0, self._table, -edge, edge)]
        if self._over(pose[:3, 3]):
            low, high, top = self._around
            meshes.append(scenery.shadow(mesh, SUN, top, -1, low, high))
        self._last[body] = key, meshes
        return meshes

    def _over(self, place: Floats) -> bool:
        low, high, _ = self._around
        spot = place[:2] - place[2] * SUN[:2] / SUN[2]
        return bool(place[2] < LOW_M and (spot > low - 0.1).all() and (spot < high + 0.1).all())

    def _threads(self, data: mujoco.MjData) -> list[Mesh]:
        found = []
        for name in rod.THREADS:
            above, below = (np.array(data.site(f"{name} {end}").xpos) for end in ("above", "below"))
            longest = float(self._model.tendon_range[self._model.tendon(name).id, 1])
            found.append(scenery.thread(above, below, longest))
        return found
