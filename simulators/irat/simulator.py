"""The simulated iRat as a process: its world in real time, its network, its camera, and the view from above."""

from functools import partial
from pathlib import Path
from typing import Any

from robots.kit.clock import TIMER, WALL, Timer, Wall
from robots.kit.drivers.irat.messages import BatteryState, Odometry, Picture, Ranges, recharge_state, velocities
from robots.kit.drivers.irat.protocol import (
    BATTERY,
    CAMERA,
    CHARGER,
    ODOMETRY,
    RANGES,
    STATE,
    VELOCITIES,
    Status,
    Velocity,
)
from simulators.common.nonvolatile import BOOTS
from simulators.common.rovers import simulator
from simulators.common.rovers.motor_board import End
from simulators.common.rovers.simulator import IDLE_S
from simulators.common.rovers.views import Image
from simulators.common.sensor import dim, take_with_stamp
from simulators.irat.cameras import Overhead, RobotCamera, jpeg, stage
from simulators.irat.plant import docked
from simulators.irat.radio import Radio
from simulators.irat.server import Network
from simulators.irat.world import World

PUBLISH_S = 0.05
LIVE_S = 0.02  # share of the charge below which the robot has no power


class Simulator(simulator.Simulator):
    """The simulated iRat. `open_floor`: the dock alone, without a maze.

    `width` of the camera's pictures: a narrower one is quick, and a little worse.
    """

    world: World

    def __init__(
        self, folder: Path, seed: int = 1, open_floor: bool = False, clock: Timer = TIMER, wall: Wall = WALL,
        real: Timer = TIMER, width: int | None = None,
    ) -> None:  # fmt: skip
        super().__init__(folder, seed, clock, wall, real)
        state = simulator.restore(folder / "state.json", docked())
        self.world = World(self.journal.note, self.faults, seed, state.pose, state.charge, not open_floor)
        self._boot = (state.boot + 1) % BOOTS
        self._keep()
        self._stage = stage(not open_floor)
        self._camera = RobotCamera(self._stage, width, seed=seed)
        self._camera.take(self.world.plant.frame)  # after an installation this compiles the rasteriser for seconds
        self._above: Overhead | None = None
        self._frozen: bytes | None = None
        self._began = self._publish_due = self._clock.monotonic()
        self.radio = Radio(self, self.faults, self.journal.note, clock, wall)
        self._network: Radio | Network = self.radio
        self.journal.note("power_on", boot=self.boot)

    @property
    def boot(self) -> int:
        """Return the number of the last start."""
        return self._boot

    def _open_line(self, port: int) -> str:
        self._network = network = Network(port, self.radio, self.faults, self.journal.note, self._clock)
        return f"ws://127.0.0.1:{network.port}"

    def _close_line(self) -> None:
        self._network.close()

    # what the network calls

    @property
    def motion(self) -> int:
        """Return the number of the newest motion."""
        return self.world.drive.motion

    def velocity(self, velocity: Velocity, epoch: int) -> str:
        """Drive; return why that is refused, or an empty text."""
        with self._lock:
            if self.world.drive.holding:
                return "the robot is being held; wait for the hold's answer"
            if self.world.battery.charge < LIVE_S:
                return "the battery is flat"
            self.world.drive.velocity(velocity.linear, velocity.angular, epoch, self.world.now)
        self._woken.set()
        return ""

    def hold(self, why: End = End.HELD) -> None:
        """Brake to rest."""
        with self._lock:
            self.world.drive.hold(why)

    def report(self) -> Status:
        """Return the state that the robot reports."""
        with self._lock:
            drive = self.world.drive
            return Status(
                self.boot, drive.motion, str(drive.end), drive.moving, drive.holding, drive.stalled,
                self.world.battery.charger_current > 0.0, self.radio.epoch,
                round(self._clock.monotonic() - self._began, 3),
            )  # fmt: skip

    # time, on its clock

    def run(self) -> None:
        """Let time pass until stopped; ticks are longer while nothing moves."""
        self._clock.spawn(self._film, "camera")
        super().run()

    def _after_tick(self, now: float) -> None:
        self._network.settle()
        if now >= self._publish_due:
            self._publish_due = max(self._publish_due + PUBLISH_S, now - PUBLISH_S)
            self._publish()

    def _has_power(self) -> bool:
        return self.world.battery.charge >= LIVE_S or self.world.charging

    def _restart(self) -> None:
        self.radio.off = not self._power
        if self.world.drive.moving:
            self.journal.note("rest", motion=self.world.drive.motion, end=str(End.LOST))
        self._network.power_off()
        self._boot, self._began = (self.boot + 1) % BOOTS, self._clock.monotonic()
        self.world.start()
        self._keep()
        self.journal.note("power_on", boot=self.boot)

    def _publish(self) -> None:
        watched = self.radio.watched
        if not watched - {CAMERA}:
            return
        with self._lock:
            world, at = self.world, self._wall()
            odometry, battery = world.odometry, world.battery
            velocity = Velocity(round(odometry.linear, 5), round(odometry.angular, 5))
            here = Odometry(odometry.x, odometry.y, odometry.heading, velocity)
            charge = BatteryState(
                battery.voltage, battery.current, battery.charge, recharge_state(battery.charger_current, battery.full)
            )
            charger = round(battery.charger_current, 4)
            ranges = Ranges(*world.plant.ranges()) if RANGES in watched else Ranges(0, 0, 0)
        self._network.publish(
            [
                (VELOCITIES, lambda n: velocities(velocity, n, at)),
                (ODOMETRY, lambda n: here.encode(n, at)),
                (RANGES, lambda n: ranges.encode(n, at)),
                (BATTERY, lambda n: charge.encode(n, at)),
                (CHARGER, lambda n: {"data": charger}),
                (STATE, lambda n: self.report().encode()),
            ]
        )

    # pictures

    def _film(self) -> None:
        """Take pictures while somebody subscribes to them."""
        due = self._clock.monotonic()
        while self._running:
            if CAMERA not in self.radio.watched:
                self._clock.sleep(IDLE_S)
                due = self._clock.monotonic()
                continue
            due = max(due + PUBLISH_S, self._clock.monotonic() - PUBLISH_S)
            self._clock.sleep(max(0.0, due - self._clock.monotonic()))
            taken = self._picture()
            if taken is not None:
                self._network.publish([(CAMERA, partial(_numbered, Picture(taken, self._wall())))])

    def _picture(self) -> bytes | None:
        """Return one JPEG with the faults of the fault board, None if the camera is gone."""
        faults = self.faults
        if faults.value("cam_gone"):
            return None
        if faults.value("cam_slow"):
            self._clock.sleep(min(faults.value("cam_slow"), 5.0))
        if faults.value("cam_freeze") and self._frozen is not None:
            return self._frozen
        picture = take_with_stamp(self._see, faults, self._wall)
        self.pictures += 1
        self._frozen = jpeg(dim(picture, faults, self.pictures))
        return self._frozen

    def _see(self) -> Image:
        with self._lock:
            hull = self.world.plant.frame
        return self._camera.take(hull, int(self.faults.value("false_marker")))

    def _from_above(self, exposure: float) -> Image:
        if self._above is None:
            self._above = Overhead(self._stage)
        with self._lock:
            hull = self.world.plant.frame
        return self._above.take(hull)

    def status(self) -> dict[str, Any]:
        """Return counters and the truth, for tests and staff; no message to the robot's owner contains it."""
        with self._lock:
            world = self.world
            return {
                **super().status(),
                "contacts": list(world.plant.contacts),
                "charging": world.charging,
                "epoch": self.radio.epoch,
            }


def _numbered(picture: Picture, sequence: int) -> dict[str, Any]:
    return picture.encode(sequence)
