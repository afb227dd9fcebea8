"""Everything that time changes: motor board, body, odometry and battery. It has no thread and no clock of its own.

A tick is 20 ms of its own time; its caller decides how fast that passes. So a simulated day can be run as fast as the
machine allows, with the same physics as in real time.
"""

from collections.abc import Callable

import numpy as np

from robots.kit.description import load
from simulators.common.battery import Battery
from simulators.common.faults import FaultBoard
from simulators.irat.drive import Drive, End
from simulators.irat.maze import along_corridors
from simulators.irat.odometry import Odometry
from simulators.irat.plant import TICK_S, Plant, Pose, docked

Note = Callable[..., None]
FLAT_V = 0.02  # share of the charge at which the robot switches itself off


class World:
    """The robot in its maze. `note` writes to the journal, `faults` says what is broken."""

    def __init__(
        self, note: Note, faults: FaultBoard, seed: int = 1, pose: Pose | None = None, charge: float = 1.0,
        with_maze: bool = True,
    ) -> None:  # fmt: skip
        self._note, self._faults, self._seed = note, faults, seed
        self.plant = Plant(pose or docked(), with_maze, seed)
        self.battery = Battery(load("irat")["battery"], charge)
        self._speed = float(load("irat")["motion"]["speed"])
        self._applied: tuple[float, ...] = (0.0, 0.0, 0.0)
        self.charging = False
        self.now, self.driven = 0.0, 0.0
        self.start()

    def start(self) -> None:
        """Switch the robot on: its motor board and its odometry begin anew; body and battery are as they are."""
        self.drive = Drive(self._note)
        self.odometry = Odometry(self._seed, self.plant.angles)

    @property
    def idle(self) -> bool:
        """Return whether nothing moves, so that ticks may be longer."""
        return not self.drive.moving and self.plant.still

    def tick(self, seconds: float = TICK_S) -> None:
        """Let time pass: 20 ms, or longer if the world is idle."""
        self.now += seconds
        self._spoil()
        left, right = self.drive.step(self.now, seconds, self.plant.rims, self.plant.wheels_still)
        before = self.plant.pose
        self.plant.step(left, right)
        after = self.plant.pose
        self.driven += float(np.hypot(after[0] - before[0], after[1] - before[1]))
        self.odometry.advance(self.plant.angles, seconds)
        contacts = self.contacts_closed
        if contacts != self.charging:
            self.charging = contacts
            self._note("charging" if contacts else "not_charging", charge=round(self.battery.charge, 4))
        self.battery.advance(seconds, max(abs(left), abs(right)) / self._speed, contacts)
        if self.battery.flat and self.drive.moving:
            self.drive.hold(End.LOST)

    @property
    def contacts_closed(self) -> bool:
        """Return whether both of the charger's contacts are closed."""
        return all(self.plant.contacts) and not self._faults.value("contacts_bent")

    def _spoil(self) -> None:
        """Do what the fault board says."""
        faults = self._faults
        slip, stall, dead = faults.value("slip"), faults.value("stall"), faults.value("ir_dead")
        if (slip, stall, dead) != self._applied:
            self._applied = slip, stall, dead
            self.plant.grip(slip)
            self.plant.block(bool(stall))
            self.plant.dead = int(dead)
        if place := faults.once("carried"):
            self.carry(int(place))
        if charge := faults.once("charge"):
            self.battery.charge, self.battery.full = min(1.0, max(0.0, charge)), False

    def carry(self, number: int) -> None:
        """Set the robot down at one of many places in the corridors, in the dock if `number` is negative.

        A number names always the same place.
        """
        places = along_corridors(0.1)
        place = docked() if number < 0 else places[(number * 37) % len(places)]
        x, y, heading = (float(value) for value in place)
        self.plant.put(x, y, heading)
        self._note("carried", x=round(x, 3), y=round(y, 3))
