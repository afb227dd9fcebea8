"""The simulated hall rover as a process: the world in real time, its firmware and its line, and the view from above."""

import threading
from math import dist
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robots.kit.clock import TIMER, WALL, Timer, Wall, poll
from robots.kit.files import replace_text, replaced
from simulators.common import stamp
from simulators.common.camera_server import CameraServer
from simulators.common.faults import FaultBoard, serve
from simulators.common.journal import Journal
from simulators.common.nonvolatile import BOOTS
from simulators.common.tcp import Listener, TcpListener
from simulators.common.threads import names, record_deaths
from simulators.srv1.cameras import Overhead, RoverCamera, stage
from simulators.srv1.drive import Drive, End
from simulators.srv1.firmware import Firmware
from simulators.srv1.flash import Flash
from simulators.srv1.link import Link, Medium
from simulators.srv1.media import Internet, Radio
from simulators.srv1.network import Network
from simulators.srv1.plant import TICK_S
from simulators.srv1.state import StoredState, keep, restore, restore_flash
from simulators.srv1.world import World

LINKS = ("wifi", "radio", "internet")  # what carries bytes: at once, the paper's radio, with the paper's delays
IDLE_S = 0.1  # of a tick while nothing moves
CATCH_UP_S = 0.5  # made up for after a stall; more is lost
LET_IN_S = 5e-5
KEEP_S, KEEP_IDLE_S = 0.5, 10.0
END_S = 1.0  # within which it comes to rest at its end


class Simulator:
    """All parts; it is the hardware that the firmware asks. `real` is the clock that all processes share.

    `stock`: a firmware without our part. `link`: see `LINKS`. `beacon`: as of `World`.
    """

    def __init__(
        self, folder: Path, seed: int = 1, clock: Timer = TIMER, wall: Wall = WALL, real: Timer = TIMER, *,
        stock: bool = False, link: str = LINKS[0], beacon: bool = False,
    ) -> None:  # fmt: skip
        folder.mkdir(parents=True, exist_ok=True)
        self._folder, self._clock, self._wall, self._lock = folder, clock, wall, clock.lock()
        self.faults, self.journal = FaultBoard(seed), Journal(folder / "journal.jsonl", real)
        kept = restore(folder / "state.json")
        self.world = World(self.journal.note, self.faults, seed, kept.pose, kept.charge, beacon)
        self._flash = Flash(restore_flash(folder / "flash"))
        self._stored = self._flash.user
        self._camera, self._busy = RoverCamera(stage(), seed=seed), threading.Lock()
        self._camera.take(self.world.plant.frame)  # after an installation this compiles the rasteriser for seconds
        self._above: Overhead | None = None
        self._frozen: NDArray[np.uint8] | None = None
        self.pictures = 0
        self._running, self._woken = True, threading.Event()
        note = self.journal.note
        self.firmware = Firmware(
            self, lambda data: self.link.say(data), note, clock, self._lock, stock=stock, boot=(kept.boot + 1) % BOOTS,
            flash=self._flash, wake=self._woken.set,
        )  # fmt: skip
        self.link = Link(self.firmware.receive, self.faults, note, clock, self._medium(link, seed))
        self._network: Network | None = None
        self._kept_at, self._power = clock.monotonic(), self.world.power
        self._keep()

    def _medium(self, link: str, seed: int) -> Medium | None:
        if link == "radio":
            return Radio(lambda: dist(self.world.plant.pose[:2], self.world.hall.tower))
        return Internet(seed) if link == "internet" else None

    def open(self, port: int = 0) -> int:
        """Open what other programs reach it by: its port (0: any), the view from above, and faults; return the port."""
        folder = self._folder
        record_deaths(self.journal)
        listener = TcpListener(port)
        self.listen(listener)
        overhead = CameraServer(self._from_above, FaultBoard(), (0.001, 0.1), wall=self._wall)
        serve(folder / "faults", self.faults, self.status)
        replace_text(folder / "overhead", f"http://127.0.0.1:{overhead.port}\n")
        replace_text(folder / "tty", f"socket://127.0.0.1:{listener.port}\n")
        return listener.port

    def listen(self, listener: Listener) -> None:
        """Let clients connect."""
        self._network = Network(self.link, self.journal.note, self._clock)
        self._network.listen(listener)

    # the hardware that the firmware asks, under the lock but for pictures

    @property
    def drive(self) -> Drive:
        """Return the motor board."""
        return self.world.drive

    def infrared(self) -> float:
        """See `Hardware`."""
        return self.world.senses.infrared()

    def sonar(self) -> float:
        """See `Hardware`."""
        return self.world.senses.sonar()

    def analogue(self, channel: int) -> int:
        """See `Hardware`."""
        return self.world.senses.analogue(channel)

    def encoders(self) -> tuple[int, int]:
        """See `Hardware`."""
        return self.world.senses.encoders()

    def compass(self) -> float:
        """See `Hardware`."""
        return self.world.senses.compass()

    def battery(self) -> float:
        """See `Hardware`."""
        return self.world.battery.voltage

    def beacon(self) -> tuple[float, float] | None:
        """See `Hardware`."""
        return self.world.senses.beacon()

    def picture(self, width: int) -> NDArray[np.uint8] | None:
        """Return one with the faults of the fault board; None while another is taken, or if there is no camera."""
        faults = self.faults
        if faults.value("cam_gone") or not self._busy.acquire(blocking=False):
            return None
        try:
            if faults.value("cam_slow"):
                self._clock.sleep(min(faults.value("cam_slow"), 5.0))
            return self._spoilt(width)
        finally:
            self._busy.release()

    def _spoilt(self, width: int) -> NDArray[np.uint8]:
        faults, picture = self.faults, self._frozen
        if picture is None or picture.shape[1] != width or not faults.value("cam_freeze"):
            begun = self._wall()
            with self._lock:
                hull, moved = self.world.plant.frame, self.world.offsets
            picture = self._camera.take(hull, width, moved)
            if faults.value("cam_stamp"):
                picture = stamp.painted(picture, int(begun * 1000))
            self._frozen = picture
            self.pictures += 1
        if faults.value("cam_flicker"):
            picture = (picture * (0.55, 1.0)[self.pictures % 2]).astype(np.uint8)
        return np.zeros_like(picture) if faults.value("cam_black") else picture

    def _from_above(self, exposure: float) -> NDArray[np.uint8]:
        if self._above is None:
            self._above = Overhead(stage())
        with self._lock:
            hull, moved = self.world.plant.frame, self.world.offsets
        return self._above.take(hull, moved)

    # time, on its clock

    @property
    def moving(self) -> bool:
        """Return whether a motion runs; once not, its rest is in the journal."""
        with self._lock:
            return self.world.drive.moving

    def run(self) -> None:
        """Let time pass until stopped; ticks are longer while nothing moves."""
        self._clock.spawn(self.firmware.run, "firmware")
        self._clock.spawn(self.link.run, "link")
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
            self.firmware.tick(self.world.now)
            last = now
            if now - self._kept_at > (KEEP_IDLE_S if self.world.idle else KEEP_S):
                self._kept_at = now
                self._keep()
        self._keep()

    def _switch(self) -> None:
        """Switch the rover off and on as the fault board or its cells say."""
        if self.faults.take("power_cycle") or self.faults.take("restart"):
            self._restart()
        if not self.world.power:
            self.link.power_off()  # whoever connects meanwhile
        if self.world.power != self._power:
            self._power = self.world.power
            self.journal.note("power_back" if self._power else "flat")
            self._restart()

    def _restart(self) -> None:
        self.link.power_off()
        self.world.senses.power_on()
        self.firmware.restart()
        self._keep()

    # what judges ask, and what outlives a kill

    def status(self) -> dict[str, Any]:
        """Return counters and the truth, for tests and staff; no message to the rover's owner contains it."""
        with self._lock:
            world = self.world
            return {
                "counts": dict(self.journal.counts),
                "pose": list(world.plant.pose),
                "rims": list(world.plant.rims),
                "reference": list(world.drive.target),
                "encoders": list(world.senses.encoders()),
                "moving": world.drive.moving,
                "stalled": world.drive.stalled,
                "motion": world.drive.motion,
                "contacts": list(world.plant.contacts),
                "moved": {name: list(off) for name, off in world.offsets.items()},
                "charge": world.battery.charge,
                "driven": world.driven,
                "boot": self.firmware.boot,
                "power": world.power,
                "pictures": self.pictures,
                "threads": names(),
            }

    def _keep(self) -> None:
        with self._lock:
            keep(self._folder / "state.json",
                 StoredState(self.world.plant.pose, self.world.battery.charge, self.firmware.boot))  # fmt: skip
            stored = self._flash.user
        if stored != self._stored:
            self._stored = stored
            with replaced(self._folder / "flash") as file:
                file.write(stored)

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
        self.firmware.stop()
        if self._network is not None:
            self._network.close()
