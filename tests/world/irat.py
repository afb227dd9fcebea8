"""The iRat in a world: simulator with its maze and pictures, rosbridge, driver and brain."""

import json
from pathlib import Path

from robots.drivers.irat.brain.process import BrainProcess
from robots.drivers.irat.driver import Driver
from simulators.irat.simulator import Simulator
from tests.faults.wishes import ROBOTS
from tests.world.brain import Brain
from tests.world.rosbridge import Network
from tests.world.world import World

NARROW = 208  # of drawn pictures: quicker, and a little worse than the robot's own


class IratRig:
    """A simulated iRat in a corridor that runs in a process of its own, and what connects an owner with it."""

    driver = "irat"

    def __init__(self, world: World, folder: Path) -> None:
        self.world, self.folder = world, folder
        self.process = world.process("simulator", delayed=False)
        self.brains: list[Brain] = []  # that were made, the newest last
        self.sim = Simulator(
            folder, world.seed, clock=world, wall=lambda: world.now().timestamp(), real=world, width=NARROW
        )
        self.faults = self.sim.faults
        self.faults.set("carried", ROBOTS["irat"].corridor)
        self.network = Network(world, self.sim.radio, self.faults, self.process)
        world.spawn(self.sim.run, "simulator", self.process)

    def _think(self, folder, packet, clock) -> BrainProcess:
        return BrainProcess(folder, packet, clock, clock, self._brain)

    def _brain(self, folder) -> Brain:
        self.brains.append(Brain(self.world, folder))
        return self.brains[-1]

    def session(self, name, address, settings, trace=None):
        """Open a session of the driver over the network."""

        class InWorld(Driver):
            clock = self.world
            opened = staticmethod(self.network.open)
            think = staticmethod(self._think)

        made = InWorld("ws://world", {**settings, "folder": str(self.folder)}, trace)
        made.wheels.seed(self.world.seed)
        return made

    def camera(self, url, rig, view="", colour=False):
        raise AssertionError("its pictures come over its own wire")

    @property
    def moving(self) -> bool:
        return self.sim.moving

    def journal(self) -> list[dict]:
        """Return what the simulator did, oldest first."""
        return [json.loads(line) for line in (self.folder / "journal.jsonl").read_text().splitlines()]

    def count(self, event: str) -> int:
        return self.sim.journal.counts[event]

    def close(self) -> None:
        self.sim.journal.close()
