"""The Mercury arm in a world: simulator, line, driver and camera."""

from pathlib import Path

import numpy as np

from robots.drivers.errors import CameraFault
from robots.drivers.mercury.driver import Driver
from simulators.mercury.__main__ import Simulator
from tests.world.wires import Cable, Port, line_of
from tests.world.world import World

EXPOSURE_S = 0.0067


class MercuryRig:
    """A simulated arm that runs in a process of its own, and what connects an owner with it."""

    driver = "mercury"

    def __init__(self, world: World, folder: Path) -> None:
        self.world, self.folder, self.cable = world, folder, Cable(world)
        self.process = world.process("simulator", delayed=False)
        self.sim = Simulator(folder, world.seed, line_of(self.cable), world, world)
        world.spawn(self.sim.run, "simulator", self.process)

    def session(self, name, address, settings, trace=None):
        """Open a session of the driver over the cable."""

        class InWorld(Driver):
            clock = self.world
            opened = staticmethod(lambda url, local: Port(self.cable))

        return InWorld(address, settings, trace)

    def camera(self, url, rig, view="", colour=False):
        return Eye(self)

    @property
    def moving(self) -> bool:
        return self.sim.body.moving

    def journal(self) -> list[dict]:
        """Return what the simulator did, oldest first."""
        return journal(self.folder)

    def count(self, event: str) -> int:
        return self.sim.journal.counts[event]

    def close(self) -> None:
        self.sim.journal.close()


class Eye:
    """The camera, without its HTTP server."""

    def __init__(self, rig: MercuryRig) -> None:
        self._rig = rig

    def grab(self, exposure_s: float | None) -> np.ndarray:
        if self._rig.sim.faults.value("cam_gone"):
            raise CameraFault("The camera does not answer.")
        return self._rig.sim.take(exposure_s or EXPOSURE_S)

    def close(self) -> None:
        pass


def journal(folder: Path) -> list[dict]:
    import json

    return [json.loads(line) for line in (folder / "journal.jsonl").read_text().splitlines()]
