"""Everything of a rover that time changes: motor board, body, sensors and battery, without a thread or a clock.

A tick is 20 ms of the world's own time; its caller decides how fast that passes. So a simulated day can be run as fast
as the machine allows, with the same physics as in real time.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from math import dist
from typing import Any

from simulators.common.faults import FaultBoard
from simulators.common.journal import Note
from simulators.common.rovers.battery import Battery
from simulators.common.rovers.body import TICK_S, Body
from simulators.common.rovers.motor_board import MotorBoard


class World(ABC):
    """A rover in its surroundings. `note` writes to the journal, `faults` says what is broken."""

    plant: Body
    drive: MotorBoard
    power = True  # of the motor board

    def __init__(self, note: Note, faults: FaultBoard, battery: Battery, motion: Mapping[str, Any]) -> None:
        self._note, self._faults, self.battery = note, faults, battery
        self._speed = float(motion["speed"])
        self._applied = (0.0, 0.0)
        self.now, self.driven = 0.0, 0.0

    @property
    def idle(self) -> bool:
        """Return whether nothing moves, so that ticks may be longer."""
        return not self.drive.moving and self.plant.still

    def tick(self, seconds: float = TICK_S) -> None:
        """Let time pass: 20 ms, or longer if the world is idle."""
        self.now += seconds
        self._spoil()
        plant, rims = self.plant, (0.0, 0.0)
        if self.power:
            rims = self.drive.step(self.now, seconds, plant.rims, plant.wheels_still)
        before = plant.pose
        plant.step(*rims)
        self.driven += dist(plant.pose[:2], before[:2])
        self._follow(seconds, max(map(abs, rims)) / self._speed)

    @abstractmethod
    def _follow(self, seconds: float, speed_share: float) -> None:
        """Let sensors and battery follow a tick of the body at this share of full speed."""

    def _spoil(self) -> None:
        """Apply the faults of the fault board."""
        slip_and_stall = self._faults.value("slip"), self._faults.value("stall")
        if slip_and_stall != self._applied:
            self._applied = slip_and_stall
            self.plant.grip(slip_and_stall[0])
            self.plant.block(bool(slip_and_stall[1]))
        self._spoil_more()
        if place := self._faults.once("carried"):
            self.carry(int(place))
        if charge := self._faults.once("charge"):
            self.battery.charge, self.battery.full = min(1.0, max(0.0, charge)), False

    @abstractmethod
    def _spoil_more(self) -> None:
        """Apply the faults that this kind of rover alone has."""

    def carry(self, number: int) -> None:
        """Set the rover down at one of many places, at its home if `number` is negative.

        A number names always the same place.
        """
        x, y, heading = self._place(number)
        self.plant.put(x, y, heading)
        self._note("carried", x=round(x, 3), y=round(y, 3))

    @abstractmethod
    def _place(self, number: int) -> tuple[float, float, float]:
        """Return the place of a number, the home of a negative one (m, m, rad)."""
