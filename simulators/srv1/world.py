"""Everything that time changes: motor board, body, sensors and battery. It has no thread and no clock of its own.

A tick is 20 ms of its own time; who runs it decides how fast that passes. So a simulated day can be run as fast as the
machine allows, with the same physics as in real time.
"""

from collections.abc import Callable
from math import hypot

import numpy as np

from robots.kit.description import load
from robots.kit.drivers.srv1.hall import hall
from simulators.common.battery import Battery
from simulators.common.faults import FaultBoard
from simulators.srv1.drive import Drive
from simulators.srv1.plant import TICK_S, Plant, Pose
from simulators.srv1.senses import Senses

Note = Callable[..., None]
OHM = 0.12  # the cells' resistance, which the description does not tell
LIVE = 0.02  # share of the charge below which the rover has no power
CHANGED_S = 60.0  # after which an attendant puts charged cells into a rover without power: there is no dock
ROOM_M = 0.25  # around a place to which the rover is carried
MOVED_M = 0.6  # how far a showcase is moved, along the hall and towards its middle


class World:
    """The rover in its hall. `note` writes to the journal, `faults` says what is broken.

    `beacon`: the tower tells the rover range and bearing, also where the description has no beacon.
    """

    def __init__(
        self, note: Note, faults: FaultBoard, seed: int = 1, pose: Pose | None = None, charge: float = 1.0,
        beacon: bool = False,
    ) -> None:  # fmt: skip
        self.hall = hall()
        self._note, self._faults = note, faults
        self.plant = Plant(pose or self.hall.home, self.hall)
        self.senses = Senses(self.plant, self.hall, faults, seed, beacon or self.hall.beacon)
        known = load("srv1")
        self.battery = Battery({**known["battery"], "resistance": OHM}, charge)
        self.drive = Drive(note)
        self._speed = float(known["motion"]["speed"])
        self._applied, self._moved = (0.0, 0.0), 0
        self._without_power_s = 0.0
        self.now, self.driven = 0.0, 0.0
        self.power = charge >= LIVE

    @property
    def offsets(self) -> dict[str, tuple[float, float]]:
        """Return the showcases that are not where the description has them, and how far they are (m, m)."""
        offsets = {case.name: self.plant.offset(case.name) for case in self.hall.cases}
        return {name: off for name, off in offsets.items() if off != (0.0, 0.0)}

    @property
    def idle(self) -> bool:
        """Return whether nothing moves, so that ticks may be longer."""
        return not self.drive.moving and self.plant.still

    def tick(self, seconds: float = TICK_S) -> None:
        """Let time pass: 20 ms, or longer if the world is idle."""
        self.now += seconds
        self._spoil()
        left = right = 0.0
        if self.power:
            left, right = self.drive.step(self.now, seconds, self.plant.rims, self.plant.wheels_still)
        before = self.plant.pose
        self.plant.step(left, right)
        after = self.plant.pose
        self.driven += hypot(after[0] - before[0], after[1] - before[1])
        self.senses.advance(self.now)
        self._drain(seconds, max(abs(left), abs(right)) / self._speed)

    def _drain(self, seconds: float, speed_share: float) -> None:
        """Take charge, and let an attendant change cells that have none left."""
        if self.power:
            self.battery.advance(seconds, speed_share, contacts=False)
        if self.battery.charge >= LIVE:
            self.power, self._without_power_s = True, 0.0
            return
        self.power = False
        self._without_power_s += seconds
        if self._without_power_s >= CHANGED_S:
            self.battery.charge = 1.0
            self._note("cells_changed")

    def _spoil(self) -> None:
        """Do what the fault board says."""
        faults = self._faults
        told = faults.value("slip"), faults.value("stall")
        if told != self._applied:
            self._applied = told
            self.plant.grip(told[0])
            self.plant.block(bool(told[1]))
        if (number := int(faults.value("moved_case"))) != self._moved:
            self._move_case(number)
        if place := faults.once("carried"):
            self.carry(int(place))
        if charge := faults.once("charge"):
            self.battery.charge = min(1.0, max(0.0, charge))

    def _move_case(self, number: int) -> None:
        """Move the showcase of that number (the first is 1), and all others back; nothing while the rover is there."""
        x, y, _ = self.plant.pose
        offsets = {}
        for count, case in enumerate(self.hall.cases, 1):
            inwards = 1 if case.at[0] < self.hall.width / 2 else -1
            offsets[case] = inwards * MOVED_M if count == number else 0.0
        if all(case.distance(x - dx, y) > ROOM_M for case, dx in offsets.items()):
            self._moved = number
            for case, dx in offsets.items():
                self.plant.move(case.name, dx, 0.0)

    def carry(self, number: int) -> None:
        """Set the rover down at one of many places of the hall, at home if `number` is negative.

        A number names always the same place.
        """
        x, y, heading = self.hall.home
        dice = np.random.default_rng(max(0, number))
        while number >= 0:
            x, y, heading = (float(v) for v in dice.uniform((0, 0, -np.pi), (self.hall.width, self.hall.depth, np.pi)))
            moved = (c.distance(x - self.plant.offset(c.name)[0], y) for c in self.hall.cases)
            if min(self.hall.distance(x, y), *moved) > ROOM_M:
                break
        self.plant.put(x, y, heading)
        self._note("carried", x=round(x, 3), y=round(y, 3))
