"""The hall rover in a world: simulator with its hall and firmware, connections, driver."""

from pathlib import Path

from robots.kit.drivers.srv1 import extension, flash
from robots.kit.drivers.srv1.driver import Driver
from robots.kit.drivers.srv1.extension import HOLD, Patrol, Velocity
from robots.kit.drivers.srv1.framing import COMMAND, Frames
from simulators.srv1.simulator import Simulator
from tests.world.rig import StreamRig, VelocityRig, Watched
from tests.world.streams import Door, Network
from tests.world.world import World

BLOCK_BYTES = flash.BLOCK + 6  # with its number, its checksum and the silence after it
HOSTILE = (
    b"M\x7f\x7f\x00", b"M\x7f", b"5", b"%v1,1,1,1*0000\n", b"%c999999*0000\n", HOLD[:-1], b"%" + b"9" * 3000, b"I",
    b"F\x50\x50", b"$A99", b"X", b"\xff\xfe\xfd", b"", b"\x00" * 500, b"x" * 100_000,
)  # fmt: skip


class RoverRig(StreamRig, VelocityRig):
    """A simulated rover that runs in a process of its own, and what connects an owner with it."""

    driver = "srv1"
    faults = ("awol", "mute", "slow", "slip", "blind_infrared", "cam_gone")
    strengths = {"slow": 0.2}
    hostile = HOSTILE

    def __init__(self, world: World, folder: Path, **options: str | bool) -> None:
        super().__init__(world, folder)
        self.use(Network(world))
        self.kind = ""  # of the command for which a motion was sent last
        self.blocks = 0  # of uploads, that were sent
        self.sim = Simulator(folder, world.seed, world, lambda: world.now().timestamp(), world, **options)
        world.spawn(self._run, "simulator", self.process)

    def _run(self) -> None:
        self.sim.listen(Door(self.cable))
        self.sim.run()

    def session(self, name, address, settings, trace=None):
        """Open a session of the driver over the network."""
        rig = self

        class InWorld(Watched, Driver):
            clock = self.world

            def opened(self, host, port, seconds):
                frames = Frames(COMMAND)

                def sent(data: bytes) -> None:
                    rig.blocks += data.startswith(flash.SOH) and len(data) == BLOCK_BYTES
                    for frame in frames.feed(data):
                        if isinstance(extension.decode(frame), Velocity | Patrol):
                            rig.kind = self.executed

                return rig.cable.connect(host, port, seconds, sent)

        return InWorld("127.0.0.1:10001", settings, trace)

    def kind_of(self, motion: dict) -> str:
        """Return the kind of command that began a motion."""
        return self.kind
