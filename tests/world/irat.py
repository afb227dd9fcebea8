"""The iRat in a world: simulator with its maze and pictures, rosbridge, driver and brain."""

import json
from pathlib import Path
from random import Random

from robots.kit.drivers.irat.brain.process import BrainProcess
from robots.kit.drivers.irat.driver import Driver
from robots.kit.drivers.irat.protocol import DRIVE, Drive
from robots.kit.drivers.rosbridge import decode, operation
from simulators.common.rovers.motor_board import End
from simulators.irat.simulator import Simulator
from tests.faults.wishes import ROBOTS
from tests.world.brain import Brain
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


class IratRig:
    """A simulated iRat in a corridor that runs in a process of its own, and what connects an owner with it."""

    driver = "irat"
    faults = ("awol", "mute", "slow", "stall", "slip", "ir_dead", "cam_gone", "cam_black", "cam_freeze")
    strengths = {"slow": 0.5, "ir_dead": 7.0}

    def __init__(self, world: World, folder: Path) -> None:
        self.world, self.folder = world, folder
        self.process = world.process("simulator", delayed=False)
        self.brains: list[Brain] = []  # that were made, the newest last
        self.sim = Simulator(
            folder, world.seed, clock=world, wall=lambda: world.now().timestamp(), real=world, width=NARROW
        )
        self.sim.faults.set("carried", ROBOTS["irat"].corridor)
        self.network = network = Network(world, self.sim.radio, self.sim.faults, self.process)
        self.pull, self.plug, self.stall, self.halve = network.unplug, network.plug, network.stall, network.halve
        self.kinds: dict[tuple[float, float], str] = {}  # for which command a velocity was sent last
        self._last: dict = {}  # the motion before
        self._end = ""  # how it ended, if nobody has held the robot since
        world.spawn(self.sim.run, "simulator", self.process)

    def _think(self, folder, packet, clock) -> BrainProcess:
        return BrainProcess(folder, packet, clock, clock, self._brain)

    def _brain(self, folder) -> Brain:
        self.brains.append(Brain(self.world, folder))
        return self.brains[-1]

    def session(self, name, address, settings, trace=None):
        """Open a session of the driver over the network."""

        rig, executed = self, ""

        class InWorld(Driver):
            clock = self.world
            think = staticmethod(self._think)

            @staticmethod
            def opened(address):
                return rig.network.open(address, sent)

            def execute(self, kind, *rest):
                nonlocal executed
                executed = kind
                return super().execute(kind, *rest)

        def sent(frame: str) -> None:
            if (asked := operation(decode(frame))).name == DRIVE and asked.op == "publish":
                velocity = Drive.decode(asked.body).velocity
                rig.kinds[velocity.linear, velocity.angular] = executed

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

    def tell(self, told) -> None:
        """Have each of the simulator's notes told, at the moment at which it is written."""

        def noted(record: dict) -> None:
            if record["event"] == "rest":
                self._end = record["end"]
            elif record["event"] in ("hold", "connected", "disconnected", "power_on"):
                self._end = ""
            told(record)

        self.sim.journal.listener = noted

    @property
    def stalled_s(self) -> float:
        """Return how long the network kept back what it was given last (s)."""
        return self.network.kept_back_s

    def is_by_itself(self, motion: dict) -> bool:
        """Tell whether a motion goes on with the one before: that rested because velocities came late, or none came.

        The driver says that the wheels are to rest while it does not hear the robot; a command's own end is a hold.
        """
        last, self._last = self._last, motion
        same = all(last.get(name) == motion[name] for name in ("epoch", "linear", "angular"))
        return same and self._end in (End.SILENCE, End.DONE)

    def kind_of(self, motion: dict) -> str:
        """Return the kind of command that began a motion."""
        return self.kinds[motion["linear"], motion["angular"]]

    def number_of(self, record: dict) -> int:
        """Return the number of the motion of which the simulator notes something."""
        return record["motion"]

    def confirms(self, record: dict) -> bool:
        """Tell whether the simulator notes that a motion came to its end: one by hand ends by a hold, or by silence."""
        return record["event"] == "rest" and record["end"] != End.LOST

    def fault(self, verb: str, value: float = 1.0) -> None:
        self.sim.faults.set(verb, value)

    def clear_faults(self) -> None:
        self.sim.faults.clear()

    def power_cycle(self) -> None:
        """Switch the robot off and on."""
        self.sim.faults.set("power_cycle", count=1)

    def meddle(self, dice: Random) -> None:
        """Connect beside the owner, say what no owner says, and go."""
        line = self.network.open("ws://hostile")
        frame = dice.choice(HOSTILE)
        line.send(frame[: dice.randrange(len(frame) + 1)] if dice.random() < 0.3 else frame)
        self.world.sleep(dice.random() * 0.1)
        line.close()

    def close(self) -> None:
        self.sim.journal.close()
