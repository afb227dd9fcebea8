"""The PUMA 560 in a world: simulator, line, driver and cameras."""

from pathlib import Path
from random import Random

import numpy as np

from robots.kit.description import load
from robots.kit.drivers.puma import protocol as wire
from robots.kit.drivers.puma.driver import Driver
from robots.kit.drivers.puma.protocol import Frame, Instruction, Receiver
from simulators.puma.cameras import Cameras
from simulators.puma.courses import Courses
from simulators.puma.simulator import Simulator
from tests.world.eyes import Eye
from tests.world.rig import Rig, Watched
from tests.world.wires import Cable, Port, line_of
from tests.world.world import World

PLAN_S = 0.03  # what a plan takes on an ordinary machine
PICTURE_S = 0.06
NARROW = 160  # of drawn pictures, for quick simulations


class InPlace(Courses):
    """Plans in the simulator's process, which takes so long."""

    def __init__(self, world: World) -> None:
        super().__init__()
        self._world, self.takes_s = world, PLAN_S

    def motion_path(self, *about):
        self._world.sleep(self.takes_s)
        return super().motion_path(*about)


class PumaRig(Rig):
    """A simulated arm that runs in a process of its own, and what connects an owner with it."""

    driver = "puma"
    width: int | None = NARROW  # of drawn pictures; None: as the description has it
    faults = ("awol", "slow", "drop", "corrupt", "double", "limit_hit", "mute", "disturb")
    strengths = {"slow": 0.5, "drop": 0.02, "corrupt": 0.02, "double": 0.02, "disturb": 40.0}

    def __init__(self, world: World, folder: Path) -> None:
        super().__init__(world, folder)
        self.use(Cable(world))
        self.by_itself: dict[int, bool] = {}  # whether the newest instruction of a number put the robot in order
        self.kinds: dict[int, str] = {}  # for which command the newest instruction of a number was sent
        opened = line_of(self.cable, int(load("puma")["line"]["baud"]))
        self.sim = Simulator(folder, lambda note: InPlace(world), opened, world.seed, world, world)
        self.cameras = Cameras(folder, world.seed, self.width)
        world.spawn(self.sim.run, "simulator", self.process)

    def session(self, name, address, settings, trace=None):
        """Open a session of the driver over the cable."""
        rig = self

        class InWorld(Watched, Driver):
            clock = self.world

            def opened(self, url, local, baud):
                return Port(rig.cable, self.note_sent)

            def note_sent(self, data: bytes) -> None:
                for frame in Receiver(wire.INSTRUCTIONS).feed(data):
                    rig.by_itself[frame.seq], rig.kinds[frame.seq] = self.recovers, self.sends_for

        return InWorld(address, settings | {"folder": str(self.folder)}, trace)

    def camera(self, url, rig, view="", colour=False):
        def take(exposure: float) -> np.ndarray:
            picture = self.cameras.take(view or "front")
            self.world.sleep(PICTURE_S)
            return picture

        return Eye(self.world, take, self.sim.faults, colour)

    @property
    def moving(self) -> bool:
        return self.sim.motions.moving

    def is_by_itself(self, motion: dict) -> bool:
        """Tell whether the owner began a motion by itself, to put the robot in order."""
        return self.by_itself[motion["seq"]]

    def kind_of(self, motion: dict) -> str:
        """Return the kind of command that began a motion; empty where the owner did by itself."""
        return self.kinds[motion["seq"]]

    def confirms(self, record: dict) -> bool:
        """Tell whether the simulator notes that a motion came to its end."""
        return record["event"] == "end" and record["end"] == "done"

    def meddle(self, dice: Random) -> None:
        """Say something on the line that no owner says: noise, and motions that are cut off or spoilt."""
        joints = tuple(dice.randrange(-90_000, 90_000) for _ in range(6))
        line = bytearray(Frame(Instruction.JOINTS, dice.randrange(256), (0, 500, *joints)).encode())
        spoilt = line.copy()
        spoilt[dice.randrange(1, len(line) - 1)] ^= 1
        self.cable.to_robot += dice.choice(
            (line[: dice.randrange(1, len(line))], spoilt, dice.randbytes(dice.randrange(1, 60)))
        )
