"""The museum arm in a world: simulator, connections, driver and cameras."""

import json
from pathlib import Path

import numpy as np

from robots.description import load
from robots.drivers.errors import CameraFault
from robots.drivers.pa10.courses import Courses
from robots.drivers.pa10.driver import Driver
from simulators.pa10.cameras import Cameras
from simulators.pa10.simulator import Simulator
from tests.world.streams import Door, Network
from tests.world.world import World

PLAN_S = 0.03  # what a plan takes on an ordinary machine


class InPlace(Courses):
    """Plans in the thread that asks, which takes so long."""

    def __init__(self, world: World) -> None:
        super().__init__()
        self._world = world

    def plan(self, *about, **more):
        self._world.sleep(PLAN_S)
        return super().plan(*about, **more)


class ArmRig:
    """A simulated arm that runs in a process of its own, and what connects an owner with it."""

    driver = "pa10"

    def __init__(self, world: World, folder: Path) -> None:
        self.world, self.folder, self.cable = world, folder, Network(world)
        self.process = world.process("simulator", delayed=False)
        line = load("pa10")["line"]
        self.sim = Simulator(
            folder, lambda note: InPlace(world), "computed_torque", "", (line["watchdog_s"], line["connect_s"]),
            world, world,
        )  # fmt: skip
        self.cameras = Cameras(folder, world.seed)
        world.spawn(self._run, "simulator", self.process)

    def _run(self) -> None:
        self.sim.network.listen(Door(self.cable))
        self.sim.run()

    def session(self, name, address, settings, trace=None):
        """Open a session of the driver over the network."""

        class InWorld(Driver):
            clock = real = self.world
            opened = staticmethod(lambda host, port, seconds: self.cable.connect(host, port, seconds))

        return InWorld("127.0.0.1:5000", settings, trace)

    def camera(self, url, rig, view="", colour=False):
        return Eye(self, view or "surroundings", colour)

    @property
    def moving(self) -> bool:
        return self.sim.app.moving

    def journal(self) -> list[dict]:
        """Return what the simulator did, oldest first."""
        return [json.loads(line) for line in (self.folder / "journal.jsonl").read_text().splitlines()]

    def count(self, event: str) -> int:
        return self.sim.journal.counts[event]

    def close(self) -> None:
        self.sim.journal.close()


class Eye:
    """One of the cameras, without its HTTP server."""

    PICTURE_S = 0.06  # what a picture takes

    def __init__(self, rig: ArmRig, view: str, colour: bool) -> None:
        self._rig, self._view, self._colour = rig, view, colour

    def grab(self, exposure_s: float | None) -> np.ndarray:
        if self._rig.sim.faults.value("cam_gone"):
            raise CameraFault("The camera does not answer.")
        picture = self._rig.cameras.take(self._view)
        self._rig.world.sleep(self.PICTURE_S)
        return picture[:, :, ::-1].copy() if self._colour else picture.mean(axis=2).astype(np.uint8)

    def close(self) -> None:
        pass
