"""The hall rover in a world: simulator with its hall and firmware, connections, driver."""

import json
from pathlib import Path
from random import Random

from robots.kit.drivers.srv1 import extension, flash
from robots.kit.drivers.srv1.driver import Driver
from robots.kit.drivers.srv1.extension import HOLD, Patrol, Velocity
from robots.kit.drivers.srv1.framing import COMMAND, Frames
from simulators.common.rovers.motor_board import End
from simulators.srv1.simulator import Simulator
from tests.world.streams import Door, Network
from tests.world.world import World

BLOCK_BYTES = flash.BLOCK + 6  # with its number, its checksum and the silence after it
HOSTILE = (
    b"M\x7f\x7f\x00", b"M\x7f", b"5", b"%v1,1,1,1*0000\n", b"%c999999*0000\n", HOLD[:-1], b"%" + b"9" * 3000, b"I",
    b"F\x50\x50", b"$A99", b"X", b"\xff\xfe\xfd", b"", b"\x00" * 500, b"x" * 100_000,
)  # fmt: skip


class RoverRig:
    """A simulated rover that runs in a process of its own, and what connects an owner with it."""

    driver = "srv1"
    faults = ("awol", "mute", "slow", "slip", "blind_infrared", "cam_gone")
    strengths = {"slow": 0.2}

    def __init__(self, world: World, folder: Path, **options: str | bool) -> None:
        self.world, self.folder, self.cable = world, folder, Network(world)
        self.pull, self.plug = self.cable.pull, self.cable.plug
        self.stall, self.halve = self.cable.stall, self.cable.halve
        self.kind = ""  # of the command for which a motion was sent last
        self.blocks = 0  # of uploads, that were sent
        self._last: dict = {}  # the motion before
        self._end = ""  # how it ended, if nobody has held the rover since
        self.process = world.process("simulator", delayed=False)
        self.sim = Simulator(folder, world.seed, world, lambda: world.now().timestamp(), world, **options)
        world.spawn(self._run, "simulator", self.process)

    def _run(self) -> None:
        self.sim.listen(Door(self.cable))
        self.sim.run()

    def session(self, name, address, settings, trace=None):
        """Open a session of the driver over the network."""

        rig, executed = self, ""

        class InWorld(Driver):
            clock = self.world

            @staticmethod
            def opened(host, port, seconds):
                frames = Frames(COMMAND)

                def sent(data: bytes) -> None:
                    rig.blocks += data.startswith(flash.SOH) and len(data) == BLOCK_BYTES
                    for frame in frames.feed(data):
                        if isinstance(extension.decode(frame), Velocity | Patrol):
                            rig.kind = executed

                return rig.cable.connect(host, port, seconds, sent)

            def execute(self, kind, *rest):
                nonlocal executed
                executed = kind
                return super().execute(kind, *rest)

        return InWorld("127.0.0.1:10001", settings, trace)

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
        return self.cable.kept_back_s

    def is_by_itself(self, motion: dict) -> bool:
        """Tell whether a motion goes on with the one before: that rested because velocities came late, or none came."""
        last, self._last = self._last, motion
        same = all(last.get(name) == motion[name] for name in ("epoch", "linear", "angular"))
        return same and self._end in (End.SILENCE, End.DONE)

    def kind_of(self, motion: dict) -> str:
        """Return the kind of command that began a motion."""
        return self.kind

    def number_of(self, record: dict) -> int:
        """Return the number of the motion of which the simulator notes something."""
        return record["motion"]

    def confirms(self, record: dict) -> bool:
        """Tell whether the simulator notes that a motion came to its end."""
        return record["event"] == "rest" and record["end"] != End.LOST

    def fault(self, verb: str, value: float = 1.0) -> None:
        self.sim.faults.set(verb, value)

    def clear_faults(self) -> None:
        self.sim.faults.clear()

    def power_cycle(self) -> None:
        """Switch the rover off and on."""
        self.sim.faults.set("power_cycle", count=1)

    def meddle(self, dice: Random) -> None:
        """Connect beside the owner, say what no owner says, and go."""
        end = self.cable.connect("hostile", 10001, 1.0)
        try:
            end.sendall(dice.choice(HOSTILE))
            self.world.sleep(dice.random() * 0.1)
        except OSError:
            pass  # it was turned away
        finally:
            end.close()

    def close(self) -> None:
        self.sim.journal.close()
