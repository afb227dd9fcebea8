"""The iRat's own code in its simulated maze, in one thread on a clock of its own: as fast as the machine allows.

Steering, docking, goals and map are those of the driver and its brain; physics, pictures and battery those of the simulator.
Only the connection and the processes are left out. The brain's answer to a picture comes 40 ms after it.
"""

import copy
import threading
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Generic, TypeVar

import cv2
import numpy as np

from robots.kit.clock import Waitable
from robots.kit.contract.errors import HardwareFault, LineSilent, MotionHeld
from robots.kit.contract.session import JSON
from robots.kit.drivers.irat.brain.messages import Answer, Feed, Packet, Seen, ToBrain
from robots.kit.drivers.irat.brain.mind import Mind
from robots.kit.drivers.irat.brain.process import SILENT_S
from robots.kit.drivers.irat.charging import Charging
from robots.kit.drivers.irat.messages import BatteryState, Odometry, Picture, Ranges, recharge_state
from robots.kit.drivers.irat.protocol import REST_S, Status, Velocity
from robots.kit.drivers.irat.roaming import Roaming
from robots.kit.drivers.irat.senses import STEP_S, Senses
from robots.kit.drivers.irat.wheels import Wheels
from simulators.common.faults import FaultBoard
from simulators.common.rovers.body import TICK_S, Pose
from simulators.irat.cameras import QUALITY, RobotCamera, Stage
from simulators.irat.world import World

T = TypeVar("T")
WIDTH, HEIGHT = 416, 240  # of the robot's camera
NARROW = 208  # of drawn pictures: quicker, and a little worse than the robot's own
THINKING_S = 0.04
REST_STEP_S = 1.0  # between two steps at rest


class Live(Generic[T]):
    """A topic whose newest value is always that of this moment, while the radio works."""

    def __init__(self, trial: "Trial", read: Callable[[], T]) -> None:
        self._trial, self._read = trial, read
        self._heard = read(), trial.now

    def _listened(self) -> tuple[T, float]:
        if not self._trial.silent_radio:
            self._heard = self._read(), self._trial.now
        return self._heard

    @property
    def value(self) -> T:
        return self._listened()[0]

    @property
    def at(self) -> float:
        return self._listened()[1]


class Line:
    """A stand-in for `IratLine`, with what the driver asks of it."""

    def __init__(self, trial: "Trial") -> None:
        self._trial, self.bridge = trial, SimpleNamespace(is_open=True)
        self.odometry = Live(trial, self._odometry)
        self.ranges = Live(trial, self._ranges)
        self.charger = Live(trial, self._charger)
        self.battery = Live(trial, self._battery)
        self.status = Live(trial, self._status)

    def _odometry(self) -> Odometry:
        seen = self._trial.world.odometry
        return Odometry(seen.x, seen.y, seen.heading, Velocity(seen.linear, seen.angular))

    def _ranges(self) -> Ranges:
        return Ranges(*self._trial.world.plant.ranges())

    def _charger(self) -> float:
        return self._trial.world.battery.charger_current

    def _battery(self) -> BatteryState:
        seen = self._trial.world.battery
        return BatteryState(seen.voltage, seen.current, seen.charge, recharge_state(seen.charger_current, seen.full))

    def _status(self) -> Status:
        drive = self._trial.world.drive
        flows = self._trial.world.battery.charger_current > 0.0
        return Status(
            0, drive.motion, str(drive.end), drive.moving, drive.holding, drive.stalled, flows, 1, self._trial.now
        )

    def drive(self, velocity: Velocity, permit: Callable[[], object]) -> None:
        permit()
        world = self._trial.world
        if not world.drive.holding and not self._trial.silent_radio:
            world.drive.velocity(velocity.linear, velocity.angular, 1, world.now)

    def obeys(self) -> None:
        """Do nothing: nobody else commands it."""

    def hold(self) -> None:
        if self._trial.silent_radio:
            raise LineSilent("The robot does not answer.")
        drive, until = self._trial.world.drive, self._trial.now + REST_S
        drive.hold()
        while drive.moving and self._trial.now < until:
            self._trial.sleep(TICK_S)
        if drive.moving:
            raise HardwareFault("The robot did not come to rest.")


class Brain:
    """A stand-in for `BrainProcess`, with the mind in this thread. `told` gets the packets of its streams."""

    def __init__(self, trial: "Trial", folder: Path) -> None:
        self._trial, self.mind = trial, Mind(folder)
        self.newest: Seen | None = None
        self.heard_at = -1e9
        self._coming: list[tuple[float, Seen]] = []
        self._number = 0
        self.told: Callable[[Packet], object] = lambda packet: None

    def feed(self, feed: Feed) -> bool:
        self._take(feed)
        return True

    def _take(self, message: ToBrain) -> Answer | None:
        answer = None
        for said in self.mind.take(message):
            if isinstance(said, Seen):
                self._coming.append((self._trial.now + THINKING_S, said))
            elif isinstance(said, Packet):
                self.told(said)
            else:
                answer = said
        return answer

    def arrive(self) -> None:
        """Hand over what has had its time."""
        while self._coming and self._coming[0][0] <= self._trial.now + 1e-9:
            self.heard_at, self.newest = self._coming.pop(0)

    def call(self, make: Callable[[int], ToBrain], seconds: float = 0.0) -> Answer:
        self._number += 1
        answer = self._take(make(self._number))
        assert answer is not None
        return answer

    def post(self, message: ToBrain) -> None:
        self._take(message)

    def keep_aim(self, aim: object) -> None:
        """Do nothing: this brain does not die."""

    def fresh(self, seconds: float = SILENT_S) -> Seen | None:
        return self.newest if self._trial.now - self.heard_at <= seconds else None


class Trial:
    """The robot, its maze and its clock (`now`, `monotonic`, `sleep`, `wait`).

    `width` of the pictures that are drawn: a narrower one is enlarged, which is quicker and a little worse.
    `each_step` is called ten times a second of the robot's time.
    """

    def __init__(
        self, folder: Path, seed: int = 1, pose: Pose | None = None, charge: float = 1.0, width: int = WIDTH,
        with_maze: bool = True, each_step: Callable[[], object] = lambda: None,
    ) -> None:  # fmt: skip
        self.now, self._due, self.each_step = 0.0, 0.0, each_step
        self.picture_bytes, self._frozen = 0, b""  # of the newest step; the newest picture
        self.faults, self.notes = FaultBoard(seed), Counter[str]()
        self.world = World(self._note, self.faults, seed, pose, charge, with_maze)
        self._camera = RobotCamera(Stage(with_maze), width, seed=seed)
        self.line, self.brain = Line(self), Brain(self, folder)
        line: Any = self.line
        brain: Any = self.brain
        self.senses = Senses(line, brain, lambda state: state, self)
        self.wheels = Wheels(line, brain, self.senses, self)
        self.wheels.seed(seed)
        self.roaming, self.charging = Roaming(self.wheels), Charging(self.wheels)
        self.truth: dict[int, tuple[float, float, float]] = {}  # where each experience of this map was made
        self._map = 0
        self.sleep(2 * STEP_S)

    def _note(self, event: str, **_: object) -> None:
        self.notes[event] += 1

    def copied(self, folder: Path) -> "Trial":
        """Return another that goes on from here, with the map in a folder of its own; what never changes is shared."""
        mind, camera = self.brain.mind, self._camera
        memo: dict[int, Any] = {id(one): one for one in (mind._markers, camera._stage, camera._stage.atlas)}
        memo |= {id(lock): threading.Lock() for lock in (mind._saving, self.faults._lock, self.wheels._sending)}
        memo |= {id(self.senses._changed): threading.Condition(), id(mind._folder): folder}
        made = copy.deepcopy(self, memo)
        made.brain.mind._keep()
        return made

    @property
    def silent_radio(self) -> bool:
        """Tell whether nothing reaches the robot, and nothing comes from it."""
        return bool(self.faults.value("awol"))

    def monotonic(self) -> float:
        return self.now

    def sleep(self, seconds: float) -> None:
        """Let the world's time pass; ten times a second the robot sees and thinks."""
        end = self.now + max(seconds, 0.0)
        while self.now < end - 1e-9:
            step = min(end - self.now, TICK_S)
            if self.world.idle:
                step = min(end, max(self._due, self.now + TICK_S)) - self.now
            self.world.tick(step)
            self.now += step
            self.brain.arrive()
            if self.now >= self._due - 1e-9:
                self._see()

    def lock(self) -> Any:
        """Make a lock, which this thread alone takes."""
        return threading.Lock()

    def wait(self, what: Waitable, seconds: float, /) -> bool:
        """Let the world's time pass until it comes, which it does in this thread or not at all."""
        end = self.now + max(seconds, 0.0)
        while not (came := what.wait(0.0)) and self.now < end - 1e-9:
            self.sleep(min(TICK_S, end - self.now))
        return came

    def _see(self) -> None:
        awake = self.senses.is_awake
        self._due = self.now + (STEP_S if awake else REST_STEP_S)
        self.picture_bytes = 0
        if awake and not self.silent_radio and not self.faults.value("cam_gone"):
            picture = self._picture()
            self.picture_bytes = len(picture)
            self.senses.take(Picture(picture, self.now))
        self.senses.step(self.now)
        held, seen = self.brain.mind.slam, self.brain.newest
        if held.map_number != self._map:
            self._map, self.truth = held.map_number, {}
        if seen is not None and seen.map_number == self._map:
            self.truth.setdefault(seen.experience, self.world.plant.pose)
        self.each_step()

    def _picture(self) -> bytes:
        """Return a grey JPEG, with the fault board's faults of the camera."""
        if self.faults.value("cam_freeze") and self._frozen:
            return self._frozen
        drawn = self._camera.take(self.world.plant.frame, int(self.faults.value("false_marker")))
        if self.faults.value("cam_black"):
            drawn = np.zeros_like(drawn)
        grey = cv2.cvtColor(drawn, cv2.COLOR_RGB2GRAY)
        if grey.shape != (HEIGHT, WIDTH):
            grey = cv2.resize(grey, (WIDTH, HEIGHT))
        self._frozen = bytes(cv2.imencode(".jpg", grey, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])[1])
        return self._frozen


def silent(_: object) -> None:
    """Take a command's progress."""


def free() -> None:
    """Permit everything."""


def until(trial: Trial, seconds: float) -> Callable[[], None]:
    """Return a permit that ends after so many seconds of the robot's time."""
    end = trial.now + seconds

    def permit() -> None:
        if trial.now > end:
            raise MotionHeld("The time is over.")

    return permit


def explore(trial: Trial, seconds: float) -> None:
    """Explore in whole slices, for at least so many seconds of the robot's time."""
    end = trial.now + seconds
    while trial.now < end:
        trial.roaming.explore(free, silent)


_explored: list[Trial] = []  # the one that all others of this process are copied from


def explored(folder: Path) -> Trial:
    """Return a trial that knows some places."""
    if not _explored:
        first = Trial(folder / "first", width=NARROW)
        explore(first, 40)
        _explored.append(first)
    return _explored[0].copied(folder)


def begun(folder: Path) -> tuple[Trial, JSON]:
    """Return a trial that knows some places, and the arguments of a goal."""
    trial = explored(folder)
    held = trial.brain.mind.slam.map
    return trial, place(trial, int(held.ids[held.count - 8]))


def place(trial: Trial, experience: int) -> JSON:
    """Return the arguments of a goal."""
    from robots.kit.slam.routes import index_of

    held = trial.brain.mind.slam
    x, y = (float(v) for v in held.map.poses[index_of(held.map, experience), :2])
    return {"map": held.map_number, "x": x, "y": y, "experience": experience}
