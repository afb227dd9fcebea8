"""The simulated iRat as a process: the world in real time, its network, its camera, and the view from above."""

import threading
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robots.kit.clock import TIMER, WALL, Timer, Wall, poll
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
from robots.kit.files import replace_text
from simulators.common import stamp
from simulators.common.camera_server import CameraServer
from simulators.common.faults import FaultBoard, serve
from simulators.common.journal import Journal
from simulators.common.nonvolatile import BOOTS
from simulators.common.threads import names, record_deaths
from simulators.irat.cameras import Overhead, RobotCamera, jpeg, stage
from simulators.irat.drive import End
from simulators.irat.plant import TICK_S
from simulators.irat.radio import Radio
from simulators.irat.server import Network
from simulators.irat.state import StoredState, keep, restore
from simulators.irat.world import World

IDLE_S = 0.1  # of a tick while nothing moves
PUBLISH_S = 0.05
CATCH_UP_S = 0.5  # made up for after a stall; more is lost
LET_IN_S = 5e-5
KEEP_S, KEEP_IDLE_S = 0.5, 10.0
END_S = 1.0  # within which it comes to rest at its end
LIVE_S = 0.02  # share of the charge below which the robot has no power


class Simulator:
    """All parts. `open_floor`: the dock alone, without a maze. `real` is the clock that all processes share.

    `width` of the camera's pictures: a narrower one is quick, and a little worse.
    """

    def __init__(
        self, folder: Path, seed: int = 1, open_floor: bool = False, clock: Timer = TIMER, wall: Wall = WALL,
        real: Timer = TIMER, width: int | None = None,
    ) -> None:  # fmt: skip
        folder.mkdir(parents=True, exist_ok=True)
        self._folder, self._clock, self._wall, self._lock = folder, clock, wall, clock.lock()
        self.faults, self.journal = FaultBoard(seed), Journal(folder / "journal.jsonl", real)
        kept = restore(folder / "state.json")
        self.world = World(self.journal.note, self.faults, seed, kept.pose, kept.charge, not open_floor)
        self.boot, self._kept_at = (kept.boot + 1) % BOOTS, 0.0
        self._keep()
        self._stage = stage(not open_floor)
        self._camera = RobotCamera(self._stage, width, seed=seed)
        self._camera.take(self.world.plant.frame)  # after an installation this compiles the rasteriser for seconds
        self._above: Overhead | None = None
        self._frozen: bytes | None = None
        self.pictures = 0
        self._running, self._woken = True, threading.Event()
        self._began = self._publish_due = self._clock.monotonic()
        self.radio = Radio(self, self.faults, self.journal.note, clock, wall)
        self._network: Radio | Network = self.radio
        self.journal.note("power_on", boot=self.boot)

    def open(self, port: int = 0) -> Network:
        """Open its doors for other programs: rosbridge at a port (0: any), the view from above, and faults."""
        folder = self._folder
        record_deaths(self.journal)
        self._network = network = Network(port, self.radio, self.faults, self.journal.note, self._clock)
        overhead = CameraServer(self._from_above, FaultBoard(), (0.001, 0.1), wall=self._wall)
        serve(folder / "faults", self.faults, self.status)
        replace_text(folder / "overhead", f"http://127.0.0.1:{overhead.port}\n")
        replace_text(folder / "tty", f"ws://127.0.0.1:{network.port}\n")
        return network

    # what stands behind the network

    @property
    def moving(self) -> bool:
        """Return whether a motion runs; once not, its rest is in the journal."""
        with self._lock:
            return self.world.drive.moving

    @property
    def motion(self) -> int:
        """Return the number of the newest motion."""
        return self.world.drive.motion

    def velocity(self, velocity: Velocity, epoch: int) -> str:
        """Drive; return why not, or an empty text."""
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
        """Return the robot's state as it tells it."""
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
        last = due = self._clock.monotonic()
        while self._running:
            idle = self.world.idle
            due += IDLE_S if idle else TICK_S
            pause = due - self._clock.monotonic()
            if idle and self._clock.wait(self._woken, max(pause, LET_IN_S)):
                due = self._clock.monotonic()
            elif not idle:
                self._clock.sleep(max(pause, LET_IN_S))
            self._woken.clear()
            if pause < -CATCH_UP_S:
                due = self._clock.monotonic()
            now = self._clock.monotonic()
            passed = min(max(now - last, LET_IN_S), IDLE_S)  # somebody may wake it twice at the same time
            with self._lock:
                self._spoil()
                self.world.tick(passed if idle and self.world.idle else TICK_S)
            self._network.settle()
            last = now
            if now >= self._publish_due:
                self._publish_due = max(self._publish_due + PUBLISH_S, now - PUBLISH_S)
                self._publish()
            self._keep_now_and_then(now)
        self._keep()

    def _spoil(self) -> None:
        """Switch the robot off and on as the fault board or its battery says."""
        if self.faults.take("power_cycle") or self.faults.take("restart"):
            self._restart()
        off = self.world.battery.charge < LIVE_S and not self.world.charging
        if off != self.radio.off:
            self.radio.off = off
            self.journal.note("flat" if off else "power_back")
            self._restart()

    def _restart(self) -> None:
        if self.world.drive.moving:
            self.journal.note("rest", motion=self.world.drive.motion, end=str(End.LOST))
        self._network.power_off()
        self.boot, self._began = (self.boot + 1) % BOOTS, self._clock.monotonic()
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
        """Return one JPEG with the faults of the fault board, None if the camera gives none."""
        faults = self.faults
        if faults.value("cam_gone"):
            return None
        if faults.value("cam_slow"):
            self._clock.sleep(min(faults.value("cam_slow"), 5.0))
        if faults.value("cam_freeze") and self._frozen is not None:
            return self._frozen
        begun = self._wall()
        with self._lock:
            hull = self.world.plant.frame
        picture = self._camera.take(hull, int(faults.value("false_marker")))
        if faults.value("cam_stamp"):
            picture = stamp.painted(picture, int(begun * 1000))
        self.pictures += 1
        if faults.value("cam_flicker"):
            picture = (picture * (0.55, 1.0)[self.pictures % 2]).astype(np.uint8)
        self._frozen = jpeg(np.zeros_like(picture) if faults.value("cam_black") else picture)
        return self._frozen

    def _from_above(self, exposure: float) -> NDArray[np.uint8]:
        if self._above is None:
            self._above = Overhead(self._stage)
        with self._lock:
            hull = self.world.plant.frame
        return self._above.take(hull)

    # what judges ask, and what outlives a kill

    def status(self) -> dict[str, Any]:
        """Return counters and the truth, for tests and staff; no message to the robot's owner contains it."""
        with self._lock:
            world = self.world
            left, right = world.plant.rims
            return {
                "counts": dict(self.journal.counts),
                "pose": list(world.plant.pose),
                "rims": [left, right],
                "reference": list(world.drive.target),
                "moving": self.moving,
                "stalled": world.drive.stalled,
                "motion": world.drive.motion,
                "contacts": list(world.plant.contacts),
                "charge": world.battery.charge,
                "charging": world.charging,
                "driven": world.driven,
                "epoch": self.radio.epoch,
                "boot": self.boot,
                "power": not self.radio.off,
                "pictures": self.pictures,
                "threads": names(),
            }

    def _keep_now_and_then(self, now: float) -> None:
        if now - self._kept_at > (KEEP_IDLE_S if self.world.idle else KEEP_S):
            self._kept_at = now
            self._keep()

    def _keep(self) -> None:
        with self._lock:
            keep(self._folder / "state.json", StoredState(self.world.plant.pose, self.world.battery.charge, self.boot))

    def stop(self, *_: object) -> None:
        """End the loop; the robot rests first."""
        threading.Thread(target=self._end, name="end").start()

    def _end(self) -> None:
        self.hold(End.LOST)
        poll(lambda: not self.moving, self._clock, END_S, TICK_S)
        self._running = False
        self._woken.set()
        self._network.close()


def _numbered(picture: Picture, sequence: int) -> dict[str, Any]:
    return picture.encode(sequence)
