"""The simulated hall rover as a process: its world in real time, its firmware, its line, and the view from above."""

import threading
from math import dist
from pathlib import Path
from typing import Any

from robots.kit.clock import TIMER, WALL, Timer, Wall
from robots.kit.drivers.srv1.hall import hall
from robots.kit.files import replaced
from simulators.common.nonvolatile import BOOTS
from simulators.common.rovers import simulator
from simulators.common.rovers.simulator import StoredState
from simulators.common.rovers.views import Image
from simulators.common.sensor import dim, take_with_stamp
from simulators.common.tcp import Listener, TcpListener
from simulators.srv1.cameras import Overhead, RoverCamera, stage
from simulators.srv1.drive import Drive
from simulators.srv1.firmware import Firmware
from simulators.srv1.flash import Flash, restore_user
from simulators.srv1.link import Link, Medium
from simulators.srv1.media import Internet, Radio
from simulators.srv1.network import Network
from simulators.srv1.world import World

LINKS = ("wifi", "radio", "internet")  # what carries bytes: at once, the paper's radio, with the paper's delays


def restore(path: Path) -> StoredState:
    """Return the state stored in `path`; a new rover, or one that would stand outside of the hall, is at its home."""
    where = hall()
    return simulator.restore(path, where.home, lambda x, y: 0 <= x <= where.width and 0 <= y <= where.depth)


class Simulator(simulator.Simulator):
    """The simulated rover; it is the hardware that the firmware asks.

    `stock`: a firmware without our part. `link`: see `LINKS`. `beacon`: as of `World`.
    """

    world: World

    def __init__(
        self, folder: Path, seed: int = 1, clock: Timer = TIMER, wall: Wall = WALL, real: Timer = TIMER, *,
        stock: bool = False, link: str = LINKS[0], beacon: bool = False,
    ) -> None:  # fmt: skip
        super().__init__(folder, seed, clock, wall, real)
        note, state = self.journal.note, restore(folder / "state.json")
        self.world = World(note, self.faults, seed, state.pose, state.charge, beacon)
        self._flash = Flash(restore_user(folder / "flash"))
        self._stored = self._flash.user
        self._camera, self._busy = RoverCamera(stage(), seed=seed), threading.Lock()
        self._camera.take(self.world.plant.frame)  # after an installation this compiles the rasteriser for seconds
        self._above: Overhead | None = None
        self._frozen: Image | None = None
        self.firmware = Firmware(
            self, lambda data: self.link.say(data), note, clock, self._lock, stock=stock, boot=(state.boot + 1) % BOOTS,
            flash=self._flash, wake=self._woken.set,
        )  # fmt: skip
        self.link = Link(self.firmware.receive, self.faults, note, clock, self._medium(link, seed))
        self._network: Network | None = None
        self._power = self.world.power
        self._keep()

    @property
    def boot(self) -> int:
        """Return the number of the last start."""
        return self.firmware.boot

    def _medium(self, link: str, seed: int) -> Medium | None:
        if link == "radio":
            return Radio(lambda: dist(self.world.plant.pose[:2], self.world.hall.tower))
        return Internet(seed) if link == "internet" else None

    def _open_line(self, port: int) -> str:
        listener = TcpListener(port)
        self.listen(listener)
        return f"socket://127.0.0.1:{listener.port}"

    def _close_line(self) -> None:
        self.firmware.stop()
        if self._network is not None:
            self._network.close()

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

    def picture(self, width: int) -> Image | None:
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

    def _spoilt(self, width: int) -> Image:
        faults, picture = self.faults, self._frozen
        if picture is None or picture.shape[1] != width or not faults.value("cam_freeze"):
            self._frozen = picture = take_with_stamp(lambda: self._see(width), faults, self._wall)
            self.pictures += 1
        return dim(picture, faults, self.pictures)

    def _see(self, width: int) -> Image:
        with self._lock:
            hull, moved = self.world.plant.frame, self.world.offsets
        return self._camera.take(hull, width, moved)

    def _from_above(self, exposure: float) -> Image:
        if self._above is None:
            self._above = Overhead(stage())
        with self._lock:
            hull, moved = self.world.plant.frame, self.world.offsets
        return self._above.take(hull, moved)

    # time, on its clock

    def run(self) -> None:
        """Let time pass until stopped; ticks are longer while nothing moves."""
        self._clock.spawn(self.firmware.run, "firmware")
        self._clock.spawn(self.link.run, "link")
        super().run()

    def _after_tick(self, now: float) -> None:
        self.firmware.tick(self.world.now)

    def _has_power(self) -> bool:
        return self.world.power

    def _switch(self) -> None:
        if not self.world.power:
            self.link.power_off()  # of a client that connects meanwhile, too
        super()._switch()

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
                **super().status(),
                "contacts": list(world.plant.contacts),
                "encoders": list(world.senses.encoders()),
                "moved": {name: list(off) for name, off in world.offsets.items()},
            }

    def _keep(self) -> None:
        with self._lock:
            super()._keep()
            stored = self._flash.user
        if stored != self._stored:
            self._stored = stored
            with replaced(self._folder / "flash") as file:
                file.write(stored)
