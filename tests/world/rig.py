"""What every robot of a world has: a simulator in a process of its own, and the means by which tests reach it."""

import json
from pathlib import Path
from random import Random
from typing import Any

from simulators.common.rovers.motor_board import End
from tests.world.world import World


class Watched:
    """Part of a driver's session: it knows for which command it sends, and whether it puts the robot in order."""

    executed, recovers = "", False

    def execute(self, kind, *rest):
        self.executed = kind
        return super().execute(kind, *rest)

    def recover(self, permit):
        self.recovers = True
        try:
            return super().recover(permit)
        finally:
            self.recovers = False

    @property
    def sends_for(self) -> str:
        """Return the kind of the command for which it sends now; empty where it puts the robot in order."""
        return "" if self.recovers else self.executed


class Rig:
    """A simulated robot, and what connects an owner with it: a cable or a network."""

    sim: Any

    def __init__(self, world: World, folder: Path) -> None:
        self.world, self.folder = world, folder
        self.process = world.process("simulator", delayed=False)

    def use(self, cable) -> None:
        """Connect the owner by this cable or network, which can be pulled, plugged in again, stalled and cut."""
        self.cable = cable
        self.pull, self.plug, self.stall, self.halve = cable.pull, cable.plug, cable.stall, cable.halve

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
        """Call `told` with each of the simulator's notes, at the moment at which it is written."""
        self.sim.journal.listener = told

    @property
    def stalled_s(self) -> float:
        """Return how long the connection kept back what it was given last (s)."""
        return self.cable.kept_back_s

    def number_of(self, record: dict) -> int:
        """Return the number of the motion of which the simulator notes something."""
        return record["motion"]

    def fault(self, verb: str, value: float = 1.0) -> None:
        self.sim.faults.set(verb, value)

    def clear_faults(self) -> None:
        self.sim.faults.clear()

    def power_cycle(self) -> None:
        """Switch the robot off and on."""
        self.sim.faults.set("power_cycle", count=1)

    def close(self) -> None:
        self.sim.journal.close()


class StreamRig(Rig):
    """A robot behind a TCP port. `hostile`: what a client that is no owner says."""

    hostile: tuple[bytes, ...] = ()

    def meddle(self, dice: Random) -> None:
        """Connect beside the owner, say what no owner says, and go."""
        end = self.cable.connect("hostile", 1, 1.0)
        try:
            end.sendall(dice.choice(self.hostile))
            self.world.sleep(dice.random() * 0.1)
        except OSError:
            pass  # it was turned away
        finally:
            end.close()


class VelocityRig(Rig):
    """A robot that is driven by velocities."""

    _last: dict = {}  # the motion before
    _end = ""  # how it ended, if nobody has held the robot since

    def tell(self, told) -> None:
        """Call `told` with each of the simulator's notes, at the moment at which it is written."""

        def noted(record: dict) -> None:
            if record["event"] == "rest":
                self._end = record["end"]
            elif record["event"] in ("hold", "connected", "disconnected", "power_on"):
                self._end = ""
            told(record)

        super().tell(noted)

    def is_by_itself(self, motion: dict) -> bool:
        """Tell whether a motion goes on with the one before: that rested because velocities came late, or none came.

        The driver says that the wheels are to rest while it does not hear the robot; a command's own end is a hold.
        """
        last, self._last = self._last, motion
        same = all(last.get(name) == motion[name] for name in ("epoch", "linear", "angular"))
        return same and self._end in (End.SILENCE, End.DONE)

    def confirms(self, record: dict) -> bool:
        """Tell whether the simulator notes that a motion came to its end: one by hand ends by a hold, or by silence."""
        return record["event"] == "rest" and record["end"] != End.LOST
