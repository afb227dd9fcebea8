"""The Mercury arm as a process.

``python -m simulators.mercury --dir DIR [--seed N] [--tcp PORT] [--baud N] [--speed FACTOR]``

In DIR it keeps `tty` (the serial line, or with --tcp the address of a serial server), `camera` and `microphone` (their
addresses), `faults` (a Unix socket), `journal.jsonl`, `bed.npy`, `pieces.json` (where the pieces of that bed lie) and
`state.json`. Where the environment has `FARHAND_SIMULATOR_SECRET`, the places follow from it.
"""

import json
import os
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robots.kit.clock import TIMER, FasterTimer, Timer
from robots.kit.description import load
from robots.kit.drivers.mercury import protocol as wire
from robots.kit.drivers.mercury.beds import FIRST, Places
from robots.kit.drivers.mercury.beds import places as places_of
from robots.kit.files import replace_text
from robots.kit.installed import SECRET
from simulators.common.camera_server import CameraServer
from simulators.common.faults import FaultBoard, serve
from simulators.common.journal import Journal
from simulators.common.microphone import Microphone
from simulators.common.nonvolatile import BOOTS, keep, restore
from simulators.common.process import arguments, run
from simulators.common.serial_line import OpenLine, line_opener
from simulators.common.threads import end_with_any, names, record_deaths
from simulators.mercury.arm import START, Body, Pose
from simulators.mercury.camera import expose
from simulators.mercury.controller import Controller
from simulators.mercury.sand import SandBed
from simulators.mercury.sound import ArmSound
from simulators.mercury.workspace import Workspace

KEEP_S = 0.02  # between two times that the place of a moving arm is stored
READOUT_S = 0.030  # the card reads the chip after the exposure


class Simulator:
    """All parts: bed, arm, controller, line and camera."""

    def __init__(
        self, folder: Path, seed: int, opened: OpenLine, clock: Timer = TIMER, real: Timer = TIMER,
        bed: Callable[[int, Places], SandBed] = SandBed, secret: str = "",
    ) -> None:  # fmt: skip
        folder.mkdir(parents=True, exist_ok=True)
        self._folder, self._clock = folder, clock
        self.faults = FaultBoard(seed)
        self.journal = Journal(folder / "journal.jsonl", real)
        description = load("mercury")
        self._secret, self._seed, self._make = secret, seed, bed
        self._number, self._places = self._hidden()
        self._shown = self._places  # those of `bed`: while another one is made, they differ
        self.bed = bed(seed + self._number - 1, self._places)
        self.bed.restore(folder / "bed.npy")
        self._state = folder / "state.json"
        pose, last_boot = restore(self._state, Pose.read, START)
        space = Workspace(description)
        self.body = Body(space.tidy_pose(pose) or START, clock.monotonic())
        boot = (last_boot + 1) % BOOTS
        self._keep(boot)
        self.controller = Controller(
            description, self.body, self._blow, self._bury, self.faults, self.journal, boot, self._keep, clock
        )
        self.line = opened(folder / "tty", self.faults, lambda: self.journal.note("refused"))
        self._rng = np.random.default_rng(seed)
        self._bed_lock = threading.Lock()
        self._exposures = description["camera"]["exposure_range_s"]
        self.microphone = Microphone(lambda: ArmSound(self.body, space, self._blowing), self.faults, clock)
        self._running = True
        self._sand: threading.Thread | None = None  # the thread of the newest burst

    def open(self) -> CameraServer:
        """Open camera, microphone and faults to other programs; its line is open already."""
        folder, (low, high) = self._folder, self._exposures
        record_deaths(self.journal)
        camera = CameraServer(self.take, self.faults, (low, high), self._clock, self.microphone)
        serve(folder / "faults", self.faults, self.status)
        address = f"http://127.0.0.1:{camera.port}"
        replace_text(folder / "microphone", f"{address}{self.microphone.path}\n")
        replace_text(folder / "camera", f"{address}\n")
        return camera

    def _keep(self, boot: int) -> None:
        keep(self._state, boot, {"pose": self.body.setpoint.as_tuple()})

    def _blowing(self) -> bool:
        return self.controller.mode == wire.Mode.BLOWING

    def _blow(self, x_mm: float, y_mm: float, seconds: float) -> None:
        def work() -> None:
            with self._bed_lock:
                self.bed.blow(x_mm, y_mm, seconds)
                if self._shown is self._places:
                    self.bed.save(self._folder / "bed.npy")

        self._sand = self._clock.spawn(work, "sand")

    def _hidden(self) -> tuple[int, Places]:
        """Return the number of the bed, and where its pieces lie: as stored, or of a bed that is new."""
        try:
            stored = json.loads((self._folder / "pieces.json").read_text())
            places = {name: (float(x), float(y)) for name, (x, y) in stored["places"].items()}
            if places.keys() == FIRST.keys():
                return int(stored["number"]), places
        except (OSError, ValueError, TypeError, KeyError, AttributeError):
            pass
        if self._secret:  # sand of a time when all beds had the same places
            (self._folder / "bed.npy").unlink(missing_ok=True)
        return 1, self._hide(1)

    def _hide(self, number: int) -> Places:
        """Store where the pieces of a bed lie, and return it."""
        places = places_of(self._secret, number)
        replace_text(self._folder / "pieces.json", json.dumps({"number": number, "places": places}))
        return places

    def _bury(self, number: int) -> None:
        """Make the bed of a number. Wherever this is cut off, the next start makes that bed, or has the one before."""
        with self._bed_lock:
            (self._folder / "bed.npy").unlink(missing_ok=True)  # sand that was dug must not lie over other places
            self._number, self._places = number, self._hide(number)
            places = self._places

        def work() -> None:
            made = self._make(self._seed + number - 1, places)  # takes about a second
            with self._bed_lock:
                if self._places is places:
                    self.bed, self._shown = made, places
                    made.save(self._folder / "bed.npy")

        self._sand = self._clock.spawn(work, "sand")

    def take(self, exposure: float) -> NDArray[np.uint8]:
        """Return a picture that is exposed for so long (s) from now on."""
        begin = self._clock.monotonic()
        self._clock.sleep(exposure + 0.004)
        poses = self.body.during(begin, begin + exposure, 5)
        with self._bed_lock:
            picture = expose(self.bed, poses, exposure, self._rng)
        self._clock.sleep(begin + exposure + READOUT_S - self._clock.monotonic())
        return picture

    def status(self) -> dict[str, Any]:
        """Return counters and pose, for tests."""
        return {
            "counts": dict(self.journal.counts),
            "pose": self.body.setpoint.as_tuple(),
            "moving": self.body.moving,
            "amplitude_m": self.body.amplitude(),
            "boot": self.controller.boot,
            "threads": names(),
            "listeners": self.microphone.listeners,
            "listened": self.microphone.openings,
        }

    def run(self) -> None:
        """Serve the line until told to stop."""
        receiver = wire.Receiver(wire.INSTRUCTIONS, lambda seq: self.controller.refuse_broken(seq, self.line.send))
        moved, kept = False, 0.0
        while self._running:
            arrived = self.line.poll(self.controller.busy)
            if arrived.data:
                for frame in receiver.feed(*arrived):
                    self.controller.handle(frame, self.line.send)
            self.controller.advance(self._clock.monotonic(), self.line.send)
            due = self._clock.monotonic() >= kept + KEEP_S or not self.body.moving
            if due and (moved or self.body.moving):  # an arm that is killed during a motion starts again near there
                self._keep(self.controller.boot)
                kept = self._clock.monotonic()
            moved = self.body.moving
        self._keep(self.controller.boot)
        if self._sand is not None:
            self._sand.join()

    def stop(self, *_: object) -> None:
        """End the loop."""
        self._running = False


def main() -> None:
    """Run the simulator."""
    end_with_any()
    parser = arguments(__doc__)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--tcp", type=int)
    parser.add_argument("--baud", type=int, default=wire.BAUD, help="of the line; the arm's own is 4800")
    options = parser.parse_args()
    clock = FasterTimer(options.speed)

    opened = line_opener(options.baud, options.tcp, clock)
    simulator = Simulator(options.dir, options.seed, opened, clock, secret=os.environ.get(SECRET, ""))
    camera = simulator.open()
    run(simulator, f"line {(options.dir / 'tty').resolve()} camera port {camera.port}")


if __name__ == "__main__":
    main()
