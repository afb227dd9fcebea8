"""The Mercury arm as a program: ``python -m simulators.mercury --dir DIR [--seed N] [--tcp PORT]``.

In DIR it keeps `tty` (the serial line, or with --tcp the address of a serial server),
`camera` (its address), `faults` (a Unix
socket), `journal.jsonl`, `bed.npy` and `state.json`.
"""

import argparse
import json
import signal
import sys
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robots.description import load
from robots.drivers.mercury import protocol as wire
from simulators.common.camera_server import CameraServer
from simulators.common.faults import FaultBoard, serve
from simulators.common.journal import Journal
from simulators.mercury.arm import Body, Pose
from simulators.mercury.camera import expose
from simulators.mercury.controller import Controller
from simulators.mercury.line import Line, TcpLine
from simulators.mercury.sand import SandBed

READOUT_S = 0.030  # the card reads the chip out after the exposure


class Simulator:
    """Everything on the bench: bed, arm, controller, line and camera."""

    def __init__(self, folder: Path, seed: int, tcp: int | None = None) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self._folder = folder
        self.faults = FaultBoard(seed)
        self.journal = Journal(folder / "journal.jsonl")
        description = load("mercury")
        self.bed = SandBed(seed)
        self.bed.restore(folder / "bed.npy")
        kept = self._kept()
        pose = Pose(*kept.get("pose", (0.0, 0.42, 0.075, 0.0)))
        self.body = Body(pose, time.monotonic())
        self.controller = Controller(
            description, self.body, self._blow, self.faults, self.journal, kept.get("boot", 0) % 255 + 1
        )
        tty = folder / "tty"
        self.line = (
            Line(tty, self.faults)
            if tcp is None
            else TcpLine(tty, self.faults, tcp, lambda: self.journal.note("refused"))
        )
        self._rng = np.random.default_rng(seed)
        self._bed_lock = threading.Lock()
        low, high = description["camera"]["exposure_range_s"]
        self.camera = CameraServer(self._take, self.faults, (low, high))
        serve(folder / "faults", self.faults, self.status)
        (folder / "camera").write_text(f"http://127.0.0.1:{self.camera.port}\n")
        self._running = True
        self._keep()

    def _kept(self) -> dict[str, Any]:
        try:
            kept = json.loads((self._folder / "state.json").read_text())
            return kept if isinstance(kept, dict) else {}
        except (OSError, ValueError):
            return {}

    def _keep(self) -> None:
        part = self._folder / "state.part"
        part.write_text(json.dumps({"pose": self.body.setpoint.as_tuple(), "boot": self.controller.boot}))
        part.replace(self._folder / "state.json")

    def _blow(self, x_mm: float, y_mm: float, seconds: float) -> None:
        def work() -> None:
            with self._bed_lock:
                self.bed.blow(x_mm, y_mm, seconds)
                self.bed.save(self._folder / "bed.npy")

        threading.Thread(target=work, name="sand").start()

    def _take(self, exposure: float) -> NDArray[np.uint8]:
        begin = time.monotonic()
        time.sleep(exposure + 0.004)
        poses = self.body.during(begin, begin + exposure, 5)
        with self._bed_lock:
            picture = expose(self.bed, poses, exposure, self._rng)
        left = begin + exposure + READOUT_S - time.monotonic()
        if left > 0:
            time.sleep(left)
        return picture

    def status(self) -> dict[str, Any]:
        """Return counters and pose, for tests."""
        return {
            "counts": dict(self.journal.counts),
            "pose": self.body.setpoint.as_tuple(),
            "moving": self.body.moving,
            "amplitude_m": self.body.amplitude(),
            "boot": self.controller.boot,
        }

    def run(self) -> None:
        """Serve the line until told to stop."""
        receiver = wire.Receiver(wire.INSTRUCTIONS)
        moved = False
        while self._running:
            data = self.line.poll(self.controller.busy)
            now = time.monotonic()
            if data:
                for frame in receiver.feed(data, now):
                    self.controller.handle(frame, self.line.send)
            self.controller.advance(now, self.line.send)
            if moved and not self.body.moving:
                self._keep()
            moved = self.body.moving
        self._keep()

    def stop(self, *_: object) -> None:
        """Leave the loop."""
        self._running = False


def main() -> None:
    """Run the simulator."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--dir", type=Path, required=True)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--tcp", type=int)
    options = parser.parse_args()
    simulator = Simulator(options.dir, options.seed, options.tcp)
    signal.signal(signal.SIGTERM, simulator.stop)
    signal.signal(signal.SIGINT, simulator.stop)
    sys.stdout.write(f"line {(options.dir / 'tty').resolve()} camera port {simulator.camera.port}\n")
    sys.stdout.flush()
    simulator.run()


if __name__ == "__main__":
    main()
