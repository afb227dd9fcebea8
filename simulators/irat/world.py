"""The world of the iRat: the robot in its maze, with dead reckoning, a dock and what the fault board does to it."""

from robots.kit.description import load
from simulators.common.faults import FaultBoard
from simulators.common.journal import Note
from simulators.common.rovers import world
from simulators.common.rovers.battery import Battery
from simulators.common.rovers.body import Pose
from simulators.common.rovers.motor_board import End, MotorBoard
from simulators.irat.maze import along_corridors
from simulators.irat.odometry import Odometry
from simulators.irat.plant import Plant, docked


def motor_board(note: Note) -> MotorBoard:
    """Return a motor board as at power on; a rim is fastest in the fastest curve."""
    description = load("irat")
    motion = description["motion"]
    return MotorBoard(description, motion["speed"] + motion["turn"] * description["body"]["track"] / 2, note)


class World(world.World):
    """See `world.World`."""

    plant: Plant

    def __init__(
        self, note: Note, faults: FaultBoard, seed: int = 1, pose: Pose | None = None, charge: float = 1.0,
        with_maze: bool = True,
    ) -> None:  # fmt: skip
        self._seed, description = seed, load("irat")
        self.plant = Plant(pose or docked(), with_maze, seed)
        super().__init__(note, faults, Battery(description["battery"], charge), description["motion"])
        self.charging = False
        self.start()

    def start(self) -> None:
        """Switch the robot on: its motor board and its odometry begin anew; body and battery are as they are."""
        self.drive = motor_board(self._note)
        self.odometry = Odometry(self._seed, self.plant.angles)

    def _follow(self, seconds: float, speed_share: float) -> None:
        self.odometry.advance(self.plant.angles, seconds)
        contacts = self.contacts_closed
        if contacts != self.charging:
            self.charging = contacts
            self._note("charging" if contacts else "not_charging", charge=round(self.battery.charge, 4))
        self.battery.advance(seconds, speed_share, contacts)
        if self.battery.flat and self.drive.moving:
            self.drive.hold(End.LOST)

    @property
    def contacts_closed(self) -> bool:
        """Return whether both of the charger's contacts are closed."""
        return all(self.plant.contacts) and not self._faults.value("contacts_bent")

    def _spoil_more(self) -> None:
        self.plant.dead = int(self._faults.value("ir_dead"))

    def _place(self, number: int) -> Pose:
        places = along_corridors(0.1)
        x, y, heading = docked() if number < 0 else places[(number * 37) % len(places)]
        return float(x), float(y), float(heading)
