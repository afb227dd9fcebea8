"""The cameras of a simulated arm, in a separate process.

The control loop writes the scene's positions into `scene.mem`; pictures are made only on request. `cameras.json` has
the address of each camera, `camera` that of the first.
"""

import argparse
import json
import logging
import os
import signal
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from robots.kit.description import load, views
from robots.kit.files import replace_text
from simulators.common.arm.render import Renderer, make
from simulators.common.camera_server import CameraServer
from simulators.common.faults import FaultBoard, serve

RANGE = (0.001, 0.1)
NICER = 10  # pictures may wait; steps of the control loop may not
PLACES = 5  # decimals of a radian or a metre: a hundredth of a pixel
NOISE = 2  # grey levels in both directions


class SharedScene:
    """The scene's positions in a file that both processes map; incomplete reads are repeated."""

    def __init__(self, path: Path, count: int, begin: bool = False) -> None:
        size = (count + 2) * 8
        if begin:
            path.write_bytes(bytes(size))
        self._values = np.memmap(path, dtype=np.float64, mode="r+", shape=(count + 2,))

    def write(self, qpos: NDArray[np.float64]) -> None:
        """Write; the two counters around the data differ meanwhile."""
        self._values[0] += 1
        self._values[1:-1] = qpos
        self._values[-1] = self._values[0]

    def read(self) -> NDArray[np.float64]:
        """Return positions that were written completely."""
        while True:
            last = self._values[-1]
            found = np.array(self._values[1:-1])
            if self._values[0] == last:
                return found


class Cameras:
    """Renders the views of `driver` in the scene `spec` on request, one picture at a time.

    `seed` is of the sensors' noise; `width` of a narrower picture of the same view, for quick simulations. `renderer`
    makes what draws the model's scene, at a width and a height.
    """

    def __init__(
        self, driver: str, spec: mujoco.MjSpec, folder: Path, seed: int | None = None, width: int | None = None,
        renderer: Callable[[mujoco.MjModel, int, int], Renderer] = make,
    ) -> None:  # fmt: skip
        self._description: dict[str, Any] = load(driver)
        camera = self._description["camera"]
        width = width or camera["width"]
        model = spec.compile()
        self._data, self._model = mujoco.MjData(model), model
        self._shared = SharedScene(folder / "scene.mem", model.nq)
        self._renderer = renderer(model, width, round(width * camera["height"] / camera["width"]))
        self._one_at_a_time = threading.Lock()
        self._taken: dict[str, tuple[bytes, NDArray[np.uint8]]] = {}
        self._dice = np.random.default_rng(seed)

    def open(self, folder: Path) -> dict[str, str]:
        """Open their servers; return the address of each camera."""
        faults = FaultBoard()
        serve(folder / "camera_faults", faults, dict)
        addresses: dict[str, str] = {}
        self._servers = []
        for name in views(self._description):
            server = CameraServer(lambda _, name=name: self.take(name), faults, RANGE)  # type: ignore[misc]
            self._servers.append(server)
            addresses[name] = f"http://127.0.0.1:{server.port}"
        replace_text(folder / "cameras.json", json.dumps(addresses))
        replace_text(folder / "camera", next(iter(addresses.values())) + "\n")
        return addresses

    def take(self, name: str) -> NDArray[np.uint8]:
        """Return a picture of shape (rows, columns, 3), red-green-blue."""
        with self._one_at_a_time:
            places = self._shared.read()
            key = np.round(places, PLACES).tobytes()
            known, picture = self._taken.get(name, (b"", None))
            if picture is None or known != key:  # a scene at rest is rendered once
                self._data.qpos[:] = places
                mujoco.mj_kinematics(self._model, self._data)
                mujoco.mj_camlight(self._model, self._data)
                picture = self._renderer.take(self._data, name)
                self._taken[name] = key, picture
        return self._noisy(picture)

    def _noisy(self, picture: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Return the picture with a sensor's noise, so that two of the same scene always differ."""
        grain = self._dice.integers(-NOISE, NOISE, picture.shape, dtype=np.int16, endpoint=True)
        return np.asarray(np.clip(picture + grain, 0, 255), np.uint8)


Opened = Callable[[Path], Cameras]  # makes the cameras of the scene whose positions are in this folder


def run(opened: Opened, folder: Path, parent: int) -> None:
    """Run until stopped, or until the control process has ended, whose number `parent` is."""
    os.nice(NICER)
    addresses = opened(folder).open(folder)
    logging.getLogger(__name__).info("cameras at %s", addresses)
    over = threading.Event()
    signal.signal(signal.SIGTERM, lambda *_: over.set())
    signal.signal(signal.SIGINT, lambda *_: over.set())
    while os.getppid() == parent and not over.wait(1.0):  # real time: a process may have died, also before this line
        pass


def main(opened: Opened, about: str | None) -> None:
    """Run as a separate process."""
    parent = os.getppid()
    parser = argparse.ArgumentParser(description=about)
    parser.add_argument("--dir", type=Path, required=True)
    logging.basicConfig(level=logging.INFO, stream=sys.stderr)
    run(opened, parser.parse_args().dir, parent)
