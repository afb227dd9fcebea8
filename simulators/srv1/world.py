"""The world of the hall rover: the rover in its hall, with sensors, cells and what the fault board does to it."""

import numpy as np

from robots.kit.description import load
from robots.kit.drivers.srv1.hall import hall
from simulators.common.faults import FaultBoard
from simulators.common.journal import Note
from simulators.common.rovers import world
from simulators.common.rovers.battery import Battery
from simulators.common.rovers.body import Pose
from simulators.srv1.drive import Drive
from simulators.srv1.plant import Plant
from simulators.srv1.senses import Senses

OHM = 0.12  # the cells' resistance, which the description does not tell
LIVE = 0.02  # share of the charge below which the rover has no power
CHANGED_S = 60.0  # after which an attendant puts charged cells into a rover without power: there is no dock
ROOM_M = 0.25  # around a place to which the rover is carried
MOVED_M = 0.6  # how far a showcase is moved, along the hall and towards its middle


class World(world.World):
    """See `world.World`. `beacon`: the tower tells range and bearing, also where the description has no beacon."""

    plant: Plant
    drive: Drive

    def __init__(
        self, note: Note, faults: FaultBoard, seed: int = 1, pose: Pose | None = None, charge: float = 1.0,
        beacon: bool = False,
    ) -> None:  # fmt: skip
        self.hall, known = hall(), load("srv1")
        self.plant = Plant(pose or self.hall.home, self.hall)
        self.senses = Senses(self.plant, self.hall, faults, seed, beacon or self.hall.beacon)
        super().__init__(note, faults, Battery({**known["battery"], "resistance": OHM}, charge), known["motion"])
        self.drive = Drive(note)
        self._moved, self._without_power_s = 0, 0.0
        self.power = charge >= LIVE

    @property
    def offsets(self) -> dict[str, tuple[float, float]]:
        """Return the showcases that are not where the description has them, and how far they are (m, m)."""
        offsets = {case.name: self.plant.offset(case.name) for case in self.hall.cases}
        return {name: off for name, off in offsets.items() if off != (0.0, 0.0)}

    def _follow(self, seconds: float, speed_share: float) -> None:
        """Let the sensors follow, take charge, and let an attendant change cells that have none left."""
        self.senses.advance(self.now)
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

    def _spoil_more(self) -> None:
        if (number := int(self._faults.value("moved_case"))) != self._moved:
            self._move_case(number)

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

    def _place(self, number: int) -> Pose:
        x, y, heading = self.hall.home
        dice = np.random.default_rng(max(0, number))
        while number >= 0:
            x, y, heading = (float(v) for v in dice.uniform((0, 0, -np.pi), (self.hall.width, self.hall.depth, np.pi)))
            moved = (c.distance(x - self.plant.offset(c.name)[0], y) for c in self.hall.cases)
            if min(self.hall.distance(x, y), *moved) > ROOM_M:
                break
        return x, y, heading
