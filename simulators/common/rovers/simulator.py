"""A simulated rover as a process: its world in real time, its journal, and the state that outlives a kill."""

import threading
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robots.kit.clock import TIMER, WALL, Timer, Wall, poll
from robots.kit.files import replace_text
from simulators.common import nonvolatile
from simulators.common.camera_server import CameraServer
from simulators.common.faults import FaultBoard, serve
from simulators.common.journal import Journal
from simulators.common.rovers.body import TICK_S, Pose
from simulators.common.rovers.motor_board import End
from simulators.common.rovers.world import World
from simulators.common.threads import names, record_deaths

IDLE_S = 0.1  # of a tick while nothing moves
CATCH_UP_S = 0.5  # made up for after a stall; more is lost
LET_IN_S = 5e-5  # the least pause, in which other threads run
KEEP_S, KEEP_IDLE_S = 0.5, 10.0  # between two times that the state is stored, while it moves and at rest
END_S = 1.0  # within which it comes to rest at its end


@dataclass(frozen=True)
class StoredState:
    """The pose (m, m, rad), the share of the charge, and the last boot number."""

    pose: Pose
    charge: float
    boot: int


def restore(path: Path, home: Pose, fits: Callable[[float, float], bool] = lambda x, y: True) -> StoredState:
    """Return the state stored in `path`; a new rover stands at home, charged. `fits`: whether it may stand there."""

    def read(stored: Any) -> tuple[Pose, float]:
        x, y, heading = map(float, stored["pose"])
        charge = float(stored["charge"])
        if not (all(map(isfinite, (x, y, heading, charge))) and fits(x, y)):
            raise ValueError(stored)
        return (x, y, heading), min(1.0, max(0.0, charge))

    (pose, charge), boot = nonvolatile.restore(path, read, (home, 1.0))
    return StoredState(pose, charge, boot)


def keep(path: Path, state: StoredState) -> None:
    """Write the state. Raises OSError."""
    nonvolatile.keep(path, state.boot, {"pose": state.pose, "charge": state.charge})


class Simulator(ABC):
    """The parts that every rover has. `real` is the clock that all processes share."""

    world: World
    _power = True

    def __init__(self, folder: Path, seed: int, clock: Timer = TIMER, wall: Wall = WALL, real: Timer = TIMER) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self._folder, self._clock, self._wall, self._lock = folder, clock, wall, clock.lock()
        self.faults, self.journal = FaultBoard(seed), Journal(folder / "journal.jsonl", real)
        self.pictures, self._kept_at = 0, clock.monotonic()
        self._running, self._woken = True, threading.Event()

    def open(self, port: int = 0) -> str:
        """Open line, view from above and faults to other programs; return the line's address. `port` 0: any."""
        record_deaths(self.journal)
        address = self._open_line(port)
        overhead = CameraServer(self._from_above, FaultBoard(), (0.001, 0.1), wall=self._wall)
        serve(self._folder / "faults", self.faults, self.status)
        replace_text(self._folder / "overhead", f"http://127.0.0.1:{overhead.port}\n")
        replace_text(self._folder / "tty", f"{address}\n")
        return address

    @abstractmethod
    def _open_line(self, port: int) -> str:
        """Listen at a port (0: any); return the address."""

    @abstractmethod
    def _close_line(self) -> None:
        """Stop listening, and end all connections."""

    @abstractmethod
    def _from_above(self, exposure: float) -> NDArray[np.uint8]:
        """Return a picture of the view from above."""

    @property
    @abstractmethod
    def boot(self) -> int:
        """Return the number of the last start."""

    # time, on its clock

    @property
    def moving(self) -> bool:
        """Return whether a motion runs; once not, its rest is in the journal."""
        with self._lock:
            return self.world.drive.moving

    def run(self) -> None:
        """Let time pass until stopped; ticks are longer while nothing moves."""
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
                self._switch()
                self.world.tick(passed if idle and self.world.idle else TICK_S)
            self._after_tick(now)
            last = now
            if now - self._kept_at > (KEEP_IDLE_S if self.world.idle else KEEP_S):
                self._kept_at = now
                self._keep()
        self._keep()

    @abstractmethod
    def _after_tick(self, now: float) -> None:
        """Do what follows a tick, without the lock; `now` is the clock's time."""

    def _switch(self) -> None:
        """Switch the rover off and on as the fault board or its battery says; the caller has the lock."""
        if self.faults.take("power_cycle") or self.faults.take("restart"):
            self._restart()
        if self._has_power() != self._power:
            self._power = not self._power
            self.journal.note("power_back" if self._power else "flat")
            self._restart()

    @abstractmethod
    def _has_power(self) -> bool:
        """Return whether the battery gives enough."""

    @abstractmethod
    def _restart(self) -> None:
        """Lose the power and get it back; the caller has the lock."""

    # what judges ask, and what outlives a kill

    def status(self) -> dict[str, Any]:
        """Return counters and the truth, for tests and staff; no message to the robot's owner contains it."""
        with self._lock:
            world = self.world
            return {
                "counts": dict(self.journal.counts),
                "pose": list(world.plant.pose),
                "rims": list(world.plant.rims),
                "reference": list(world.drive.target),
                "moving": world.drive.moving,
                "stalled": world.drive.stalled,
                "motion": world.drive.motion,
                "charge": world.battery.charge,
                "driven": world.driven,
                "boot": self.boot,
                "power": self._power,
                "pictures": self.pictures,
                "threads": names(),
            }

    def _keep(self) -> None:
        with self._lock:
            state = StoredState(self.world.plant.pose, self.world.battery.charge, self.boot)
            keep(self._folder / "state.json", state)

    def stop(self, *_: object) -> None:
        """End the loop; the rover rests first."""
        threading.Thread(target=self._end, name="end").start()

    def _end(self) -> None:
        with self._lock:
            self.world.drive.hold(End.LOST)
        self._woken.set()
        poll(lambda: not self.moving, self._clock, END_S, TICK_S)
        self._running = False
        self._woken.set()
        self._close_line()
