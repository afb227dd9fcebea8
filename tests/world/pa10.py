"""The museum arm in a world: simulator, connections, driver and cameras."""

from collections.abc import Iterable
from math import radians
from pathlib import Path

import numpy as np

from robots.kit.description import load
from robots.kit.drivers.pa10.courses import Courses
from robots.kit.drivers.pa10.driver import Driver
from robots.kit.drivers.pa10.protocol import End
from simulators.pa10.cameras import Cameras
from simulators.pa10.simulator import Simulator
from tests.world.eyes import Eye
from tests.world.rig import StreamRig, Watched
from tests.world.streams import Door, Network
from tests.world.world import World

NARROW = 160  # of rendered pictures: four times as quick as the arm's own
PLAN_S = 0.03  # what a plan takes on an ordinary machine


class InPlace(Courses):
    """Plans in the thread that asks, which takes so long."""

    def __init__(self, world: World) -> None:
        super().__init__()
        self._world = world

    def plan(self, *about, **more):
        self._world.sleep(PLAN_S)
        return super().plan(*about, **more)


HOSTILE = tuple(line + b"\n" for line in (
    b"j 1e308 0 0 0 0 0", b"j nan 25 75 0 80 0", b"j -inf 0 0 0 0 0", b"j 0 25 75 0 80 0", b"J 1 1 1 1 1 1", b"l 1 2",
    b"k 400 0 300 180 0 180", b"g 1", b"p 1", b"h 1", b"i nan", b"i -1", b"i 0.5", b"u nan", b"\xff\xfe\xfd", b"",
    b"\x00", b"j " + b"9" * 3000, b"x" * 100_000,
))  # fmt: skip
PICTURE_S = 0.06  # what a picture takes


class ArmRig(StreamRig):
    """A simulated arm that runs in a process of its own, and what connects an owner with it."""

    driver = "pa10"
    width: int | None = NARROW  # of rendered pictures; None: as the description has it
    faults = ("awol", "mute", "slow", "disturb", "slip", "cam_gone")
    strengths = {"slow": 0.5, "disturb": 60.0}
    hostile = HOSTILE

    def __init__(self, world: World, folder: Path) -> None:
        super().__init__(world, folder)
        self.use(Network(world))
        self.by_itself: dict[tuple[float, ...], bool] = {}  # whether the newest line to a target put the arm in order
        self.kinds: dict[tuple[float, ...], str] = {}  # for which command the newest line to a target was sent
        line = load("pa10")["line"]
        self.sim = Simulator(
            folder, lambda note: InPlace(world), "computed_torque", "", (line["watchdog_s"], line["connect_s"]),
            world, world,
        )  # fmt: skip
        self.cameras = Cameras(folder, world.seed, self.width)
        world.spawn(self._run, "simulator", self.process)

    def _run(self) -> None:
        self.sim.network.listen(Door(self.cable))
        self.sim.run()

    def session(self, name, address, settings, trace=None):
        """Open a session of the driver over the network."""
        rig = self

        class InWorld(Watched, Driver):
            clock = real = self.world

            def opened(self, host, port, seconds):
                return rig.cable.connect(host, port, seconds, self.note_sent)

            def note_sent(self, data: bytes) -> None:
                if data[:1] == b"j":
                    there = target(radians(float(v)) for v in data.split()[1:7])
                    rig.by_itself[there], rig.kinds[there] = self.recovers, self.sends_for

        made = InWorld("127.0.0.1:5000", {**settings, "folder": str(self.folder)}, trace)
        if self.width is not None:  # blocks are not recognised in pictures that are smaller than described
            made.tasks._eyes = None
        return made

    def camera(self, url, rig, view="", colour=False):
        def take(exposure: float) -> np.ndarray:
            picture = self.cameras.take(view or "surroundings")
            self.world.sleep(PICTURE_S)
            return picture

        return Eye(self.world, take, self.sim.faults, colour)

    @property
    def moving(self) -> bool:
        return self.sim.app.moving

    def is_by_itself(self, motion: dict) -> bool:
        """Tell whether the owner began a motion by itself, to put the arm in order."""
        return self.by_itself.get(target(motion.get("target", ())), False)

    def kind_of(self, motion: dict) -> str:
        """Return the kind of command that began a motion to a place; empty where the owner did by itself, and of jogs."""
        return self.kinds.get(target(motion.get("target", ())), "")

    def confirms(self, record: dict) -> bool:
        """Tell whether the simulator notes that a motion came to its end."""
        return record["event"] == "end" and record["end"] == End.DONE

    def power_cycle(self) -> None:
        """Start the control application again, as its watchdog does."""
        self.sim.faults.set("restart", count=1)


def target(joints: Iterable[float]) -> tuple[float, ...]:
    """Return six joints (rad) as a motion's name."""
    return tuple(round(v, 4) for v in joints)
