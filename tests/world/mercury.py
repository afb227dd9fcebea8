"""The Mercury arm in a world: simulator, line, driver and camera."""

from pathlib import Path
from random import Random

from robots.kit.drivers.mercury.driver import Driver
from robots.kit.drivers.mercury.protocol import BAUD, move_xyz
from simulators.mercury.__main__ import Simulator
from tests.unit.sand_beds import fresh
from tests.world.eyes import Eye
from tests.world.rig import Rig, Watched
from tests.world.wires import Cable, Port, line_of
from tests.world.world import World

SEQ = 2  # where the number of an instruction stands in it


class MercuryRig(Rig):
    """A simulated arm that runs in a process of its own, and what connects an owner with it."""

    driver = "mercury"
    faults = ("awol", "slow", "drop", "corrupt", "double", "limit_hit", "mute")
    strengths = {"slow": 0.5, "drop": 0.1, "corrupt": 0.1, "double": 0.1}
    secret = ""  # from which the places of hidden pieces follow

    def __init__(self, world: World, folder: Path) -> None:
        super().__init__(world, folder)
        self.use(Cable(world))
        self.by_itself: dict[int, bool] = {}  # whether the newest instruction of a number put the robot in order
        self.kinds: dict[int, str] = {}  # for which command the newest instruction of a number was sent
        self.sim = Simulator(folder, world.seed, line_of(self.cable, BAUD), world, world, fresh, self.secret)
        world.spawn(self.sim.run, "simulator", self.process)

    def session(self, name, address, settings, trace=None):
        """Open a session of the driver over the cable."""
        rig = self

        class InWorld(Watched, Driver):
            clock = self.world

            def opened(self, url, local, baud):
                return Port(rig.cable, self.note_sent)

            def note_sent(self, data: bytes) -> None:
                rig.by_itself[data[SEQ]], rig.kinds[data[SEQ]] = self.recovers, self.sends_for

        return InWorld(address, settings, trace)

    def camera(self, url, rig, view="", colour=False):
        return Eye(self.world, self.sim.take, self.sim.faults, colour)

    @property
    def moving(self) -> bool:
        return self.sim.body.moving

    def is_by_itself(self, motion: dict) -> bool:
        """Tell whether the owner began a motion by itself, to put the robot in order."""
        return self.by_itself[motion["seq"]]

    def kind_of(self, motion: dict) -> str:
        """Return the kind of command that began a motion; empty where the owner did by itself."""
        return self.kinds[motion["seq"]]

    def number_of(self, record: dict) -> int:
        """Return the number of the motion of which the simulator notes something."""
        return record["seq"]

    def confirms(self, record: dict) -> bool:
        """Tell whether the simulator notes that a motion came to its end."""
        return record["event"] == "rest" and not record["braked"]

    def meddle(self, dice: Random) -> None:
        """Say something on the line that no owner says: noise, and motions that are cut off or spoilt."""
        frame = bytearray(move_xyz(dice.randrange(256), *(dice.uniform(-300.0, 300.0) for _ in range(3))).encode())
        cut, spoilt = frame[: dice.randrange(1, len(frame))], frame[:-1] + bytes([frame[-1] ^ 1])
        self.cable.to_robot += dice.choice((cut, spoilt, dice.randbytes(dice.randrange(1, 60))))
