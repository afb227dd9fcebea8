"""The iRat in a world: simulator with its maze and pictures, rosbridge, driver and brain."""

from pathlib import Path
from random import Random

from robots.kit.drivers.irat.brain.process import BrainProcess
from robots.kit.drivers.irat.driver import Driver
from robots.kit.drivers.irat.protocol import DRIVE, Drive
from robots.kit.drivers.rosbridge import decode, operation
from simulators.irat.simulator import Simulator
from tests.faults.wishes import ROBOTS
from tests.world.brain import Brain
from tests.world.rig import VelocityRig, Watched
from tests.world.rosbridge import Network
from tests.world.world import World

HOSTILE = (
    "{", "7", "{}", "[" * 5000, '{"op": "fragment"}', '{"op": "subscribe", "topic": "../../etc"}', "x" * 20_000,
    *(
        f'{{"op": "publish", "topic": "/irat/{topic}", "msg": {message}}}'
        for topic in ("cmd_vel", "drive")
        for message in (
            "5", '{"linear": {"x": 1e308}}', '{"linear": {"x": 0.1}}', '{"angular": {"z": 1e999}}',
            '{"epoch": 1, "sec": 0, "twist": {"linear": {"x": 0.1}}}', '{"epoch": 1e300, "sec": "now", "twist": 5}',
        )
    ),
)  # fmt: skip
NARROW = 208  # of drawn pictures: quicker, and a little worse than the robot's own


class IratRig(VelocityRig):
    """A simulated iRat in a corridor that runs in a process of its own, and what connects an owner with it."""

    driver = "irat"
    faults = ("awol", "mute", "slow", "stall", "slip", "ir_dead", "cam_gone", "cam_black", "cam_freeze")
    strengths = {"slow": 0.5, "ir_dead": 7.0}

    def __init__(self, world: World, folder: Path) -> None:
        super().__init__(world, folder)
        self.brains: list[Brain] = []  # that were made, the newest last
        self.sim = Simulator(
            folder, world.seed, clock=world, wall=lambda: world.now().timestamp(), real=world, width=NARROW
        )
        self.sim.faults.set("carried", ROBOTS["irat"].corridor)
        self.use(Network(world, self.sim.radio, self.sim.faults, self.process))
        self.kinds: dict[tuple[float, float], str] = {}  # for which command a velocity was sent last
        world.spawn(self.sim.run, "simulator", self.process)

    def _think(self, folder, packet, clock) -> BrainProcess:
        return BrainProcess(folder, packet, clock, clock, self._brain)

    def _brain(self, folder) -> Brain:
        self.brains.append(Brain(self.world, folder))
        return self.brains[-1]

    def session(self, name, address, settings, trace=None):
        """Open a session of the driver over the network."""
        rig = self

        class InWorld(Watched, Driver):
            clock = self.world
            think = staticmethod(self._think)

            def opened(self, address):
                return rig.cable.open(address, self.note_sent)

            def note_sent(self, frame: str) -> None:
                if (asked := operation(decode(frame))).name == DRIVE and asked.op == "publish":
                    velocity = Drive.decode(asked.body).velocity
                    rig.kinds[velocity.linear, velocity.angular] = self.executed

        made = InWorld("ws://world", {**settings, "folder": str(self.folder)}, trace)
        made.wheels.seed(self.world.seed)
        return made

    def kind_of(self, motion: dict) -> str:
        """Return the kind of command that began a motion."""
        return self.kinds[motion["linear"], motion["angular"]]

    def meddle(self, dice: Random) -> None:
        """Connect beside the owner, say what no owner says, and go."""
        line = self.cable.open("ws://hostile")
        frame = dice.choice(HOSTILE)
        line.send(frame[: dice.randrange(len(frame) + 1)] if dice.random() < 0.3 else frame)
        self.world.sleep(dice.random() * 0.1)
        line.close()
