"""A picture of the iRat's camera by the rasteriser, beside MuJoCo's own rays in the same places.

The rays are cast at the walls, the dock and the floor alone and shaded flatly; the rasteriser draws the hall, posters
and things besides, with textures. Both in one thread; the two take turns, so that a busy machine is so for both.
"""

import os
import time

import mujoco
import numpy as np

from benchmarks.stage import tell
from robots.kit.description import load
from simulators.common.mesh import placed
from simulators.common.raster import Lens
from simulators.irat import scene
from simulators.irat.cameras import RobotCamera, Stage
from simulators.irat.maze import along_corridors

EVERY_M = float(os.environ.get("FARHAND_BENCH_EVERY_M", "0.2"))
GOAL = 5.0


class Rays:
    """MuJoCo's rays, one a pixel, shaded by Lambert's law."""

    def __init__(self) -> None:
        self._model = scene.spec().compile()
        self._data = mujoco.MjData(self._model)
        mujoco.mj_forward(self._model, self._data)
        camera = load("irat")["camera"]
        self._lens = Lens(camera["width"], camera["height"], camera["field"])
        rows, columns = np.mgrid[0 : self._lens.height, 0 : self._lens.width]
        rays = np.stack([
            np.ones(rows.shape), -(columns + 0.5 - self._lens.width / 2) / self._lens.focal,
            -(rows + 0.5 - self._lens.height / 2) / self._lens.focal,
        ], axis=-1).reshape(-1, 3)  # fmt: skip
        self._rays = rays / np.linalg.norm(rays, axis=1, keepdims=True)
        self._mount = placed(camera["ahead"], 0, camera["high"])
        count = len(rays)
        self._geom, self._away, self._normal = np.empty(count, np.int32), np.empty(count), np.empty(3 * count)
        self._groups = np.array([0, 1, 1, 1, 1, 1], np.uint8)

    def take(self, hull: np.ndarray) -> np.ndarray:
        """Return the picture, shape (height, width), from a hull at this pose (4 x 4)."""
        eye = hull @ self._mount
        rays = np.ascontiguousarray(self._rays @ eye[:3, :3].T)
        mujoco.mj_multiRay(
            self._model, self._data, np.ascontiguousarray(eye[:3, 3]), rays.reshape(-1), self._groups, True, -1,
            self._geom, self._away, self._normal, len(rays), 10.0,
        )  # fmt: skip
        facing = np.abs(np.einsum("ij,ij->i", self._normal.reshape(-1, 3), rays))
        light = np.where(self._geom >= 0, 90 + 140 * facing, 200)
        return light.astype(np.uint8).reshape(self._lens.height, self._lens.width)


def main() -> None:
    """Compare both in places all over the maze, by the processor's time."""
    ours, rays = RobotCamera(Stage()), Rays()
    hulls = [placed(x, y, 0, heading) for x, y, heading in along_corridors(EVERY_M)]
    ours.take(hulls[0]), rays.take(hulls[0])
    times: dict[str, list[float]] = {"raster": [], "rays": []}
    for hull in hulls:
        for name, camera in (("raster", ours), ("rays", rays)):
            begun = time.thread_time()
            camera.take(hull)
            times[name].append(1000 * (time.thread_time() - begun))
    medians = {name: float(np.median(found)) for name, found in times.items()}
    for name, found in times.items():
        print(
            f"{name}: median {medians[name]:.2f} ms, 90 % within {np.quantile(found, 0.9):.2f} ms, {len(found)} pictures"
        )
    small = RobotCamera(Stage(), width=104)
    small.take(hulls[0])
    begun = time.thread_time()
    for hull in hulls:
        small.take(hull)
    medians["raster, 104 x 60"] = 1000 * (time.thread_time() - begun) / len(hulls)
    print(f"raster, 104 x 60: mean {medians['raster, 104 x 60']:.2f} ms")
    ratio = medians["rays"] / medians["raster"]
    tell(
        "raster",
        ratio,
        "times as fast as MuJoCo's rays",
        f"{GOAL:g}",
        ratio >= GOAL,
        {k: round(v, 2) for k, v in medians.items()},
    )


if __name__ == "__main__":
    main()
