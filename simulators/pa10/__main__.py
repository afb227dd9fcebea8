"""The museum arm as a program: ``python -m simulators.pa10 --dir DIR [--port N] [--controller pd]``.

In DIR it keeps `tty` (the address it listens at), `camera` and `cameras.json`, `faults` (a
Unix socket), `journal.jsonl`, `programs.json` and `scene.npy`.
"""

import argparse
import contextlib
import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from robots.description import load
from robots.drivers.pa10.courses import Courses
from robots.drivers.pa10.protocol import ArmState, Request
from simulators.common.faults import FaultBoard, serve
from simulators.common.journal import Journal
from simulators.pa10.application import Application
from simulators.pa10.cameras import SharedScene
from simulators.pa10.controllers import CONTROLLERS
from simulators.pa10.plant import Measured, Plant
from simulators.pa10.scene import BLOCKS, STEP_S, Judge
from simulators.pa10.server import Network, Watchdog

SHARE_EVERY = 20  # steps between two positions for the cameras: 40 ms
JUDGE_EVERY = 5
CATCH_UP = 25  # steps that are made up for after a stall; more than that is lost time
LET_IN_S = 5e-5  # a loop that is behind rests at least so long, or it would never let the network in
SWITCH_S = 2e-4  # for so long the interpreter may stay with whoever plans; Python's own 5 ms are two steps and a half
SLIP_STEPS = 150
LOOK_EVERY = 500  # steps between two looks at what has fallen
FALLEN_M, FALLEN_LOOKS = -0.1, 3
OBJECTS = tuple(name for name, _, _ in BLOCKS)
PROGRAMS = {
    1: "# greet\nj 0 -20 60 0 50 0\nR 2\nj 0 -20 60 0 90 0\nj 0 -20 60 0 30 0\nE\nj 0 25 75 0 80 0",
    2: "# red onto yellow\ng 0\nk 500 160 150 180 0 180\nl 500 160 20 180 0 180\ng 1\nl 500 160 150 180 0 180\n"
    "k 560 50 150 180 0 180\nl 560 50 61 180 0 180\ng 0\nl 560 50 150 180 0 180",
}


class Simulator:
    """Plant, controller, application, network and cameras."""

    def __init__(self, folder: Path, port: int, controller: str, token: str, watchdog: tuple[float, float]) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self._folder = folder
        self.faults, self.journal = FaultBoard(), Journal(folder / "journal.jsonl")
        self._courses = Courses()
        self.plant = Plant(qpos=self._kept())
        self._controller = CONTROLLERS[controller]()
        self._judge, self.nearest = Judge(self.plant.model), (Judge.FAR, "")
        self.boot, self.late, self.steps = 0, 0, 0
        self.worst, self.error = 0.0, 0.0  # lateness of a step (s); distance of a joint from its reference (rad)
        self._fallen: dict[str, int] = {}
        self._slips = 0  # steps for which the gripper gives way
        self._measured = self.plant.measured()
        self.programs = dict(PROGRAMS) | self._kept_programs()
        self._begin_application("power on")
        self._shared = SharedScene(folder / "scene.mem", self.plant.model.nq, begin=True)
        self._shared.write(self.plant.qpos)
        self.network = Network(
            port, self.act, self.plan, self.wait, self.faults, self.journal.note, self._take_over, token
        )
        self._running = True
        serve(folder / "faults", self.faults, self.status)
        self._cameras = subprocess.Popen(  # noqa: S603 - our own program
            [sys.executable, "-m", "simulators.pa10.cameras", "--dir", str(folder)],
            env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},  # more of them only wait for each other, busily
            stderr=subprocess.DEVNULL,
        )
        (folder / "tty").write_text(f"127.0.0.1:{self.network.port}\n")
        Watchdog(self.network, *watchdog, self.restart)

    def _kept(self) -> Any:
        try:
            return np.load(self._folder / "scene.npy", allow_pickle=False)
        except (OSError, ValueError):
            return None

    def _kept_programs(self) -> dict[int, str]:
        with contextlib.suppress(OSError, ValueError):
            return {int(k): str(v) for k, v in json.loads((self._folder / "programs.json").read_text()).items()}
        return {}

    def _begin_application(self, why: str) -> None:
        self.boot += 1
        gripper = int(self._measured.opening < 0.03)
        self.app = Application(self._courses, self._measured.q.copy(), self.journal.note, self.programs, gripper)
        self.journal.note("application", boot=self.boot, why=why)

    def restart(self, why: str) -> None:
        """Start the control application again: what moved rests where it is, the line is dropped."""
        self.app.hold()
        while self.app.moving and self._running:
            time.sleep(STEP_S)
        self.network.drop(f"watchdog: {why}")
        self._begin_application(why)

    def act(self, request: Request) -> str:
        """Answer a request that is not the network's own."""
        if request.letter == "w":
            return self.app.letter()
        if request.letter == "s":
            return self.state().encode()
        return self.app.take(request)

    def plan(self, request: Request) -> Callable[[], str]:
        """Return what answers a request that takes its time: of this application, and as of now."""
        return partial(self.app.take, request, self.app.asked)

    def _take_over(self, number: int, text: str) -> None:
        """Keep a program that was sent."""
        self.programs[number] = text
        part = self._folder / "programs.part"
        part.write_text(json.dumps(self.programs))
        part.replace(self._folder / "programs.json")

    def wait(self, seconds: float) -> str:
        """Answer `W`."""
        return self.app.wait_for_rest(seconds)

    def state(self) -> ArmState:
        """Return the answer to `s`."""
        app, now = self.app, self._measured
        return ArmState(
            app.mode, app.motion, app.end, self.boot, app.program, app.step_of, app.gripper, now.opening,
            app.moving, tuple(now.q), tuple(now.v), tuple(now.torque), app.note[:80],
        )  # fmt: skip

    def status(self) -> dict[str, Any]:
        """Return counters and places, for tests."""
        return {
            "counts": dict(self.journal.counts),
            "q": self._measured.q.tolist(),
            "moving": self.app.moving,
            "mode": str(self.app.mode),
            "boot": self.boot,
            "late": self.late,
            "worst_ms": round(1000 * self.worst, 2),
            "worst_error": round(self.error, 6),
            "steps": self.steps,
            "nearest": self.nearest,
            "objects": {
                name: self.plant.place(name).round(4).tolist() for name in ("red", "yellow", "blue", "green", "tip")
            },
        }

    def run(self) -> None:
        """Control at 500 Hz until told to stop; a late step is made up for."""
        due = time.monotonic()
        while self._running:
            due += STEP_S
            pause = due - time.monotonic()
            time.sleep(max(pause, LET_IN_S))
            behind = time.monotonic() - due
            self.late += behind > STEP_S
            self.worst = max(self.worst, behind)
            if pause <= 0:
                due = max(due, time.monotonic() - CATCH_UP * STEP_S)
            self._one()
        self._keep()

    def _one(self) -> None:
        self.steps += 1
        measured: Measured = self.plant.measured()
        reference = self.app.step(measured.q, measured.v)
        self._measured = measured
        if self.app.moving:
            self.error = max(self.error, float(np.max(np.abs(reference.q - measured.q))))
        self._spoil()
        torque = self._controller.torques(reference.q, reference.v, reference.a, measured)
        self._slips = max(0, self._slips - 1)
        self.plant.step(torque, 0 if self._slips else reference.gripper)
        if self.steps % JUDGE_EVERY == 0 and self.app.moving:
            self.nearest = min(self.nearest, self._judge.nearest(self.plant.data))
        if self.steps % LOOK_EVERY == 0:
            self._tidy()
        if self.steps % SHARE_EVERY == 0:
            self._shared.write(self.plant.qpos)

    def _spoil(self) -> None:
        """Disturb the arm (N m on S1) and let an object slip, as the fault board says."""
        self.plant.disturbance[0] = self.faults.value("disturb")
        if self.faults.take("restart"):
            threading.Thread(target=self.restart, args=("asked for by a fault verb",), daemon=True).start()
        if self.faults.take("slip"):
            self._slips = SLIP_STEPS
            self.journal.note("slip")

    def _tidy(self) -> None:
        """Put back what has lain beside the table for a while, as a keeper would."""
        for name in OBJECTS:
            away = self.plant.place(name)[2] < FALLEN_M
            self._fallen[name] = self._fallen.get(name, 0) + 1 if away else 0
            if self._fallen[name] > FALLEN_LOOKS:
                self.plant.put_back(name)
                self.journal.note("put_back", what=name)

    def _keep(self) -> None:
        np.save(self._folder / "scene.npy", self.plant.qpos)

    def stop(self, *_: object) -> None:
        """Leave the loop; the arm rests first."""
        threading.Thread(target=self._end, name="end").start()

    def _end(self) -> None:
        self.app.hold()
        until = time.monotonic() + 2.0
        while self.app.moving and time.monotonic() < until:
            time.sleep(STEP_S)
        self._running = False
        self.network.close()
        self._cameras.terminate()


def first_in_line() -> None:
    """Let the calling thread go before everything else that wants a processor, where the system allows it.

    It rests in every step, so that nobody starves. Threads that it begins are ordinary ones again.
    """
    with contextlib.suppress(AttributeError, OSError):  # not known here; not allowed to an ordinary user
        os.sched_setscheduler(0, os.SCHED_RR | os.SCHED_RESET_ON_FORK, os.sched_param(1))


def main() -> None:
    """Run the simulator."""
    line = load("pa10")["line"]
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--dir", type=Path, required=True)
    parser.add_argument("--port", type=int, default=0)
    parser.add_argument("--controller", choices=sorted(CONTROLLERS), default="computed_torque")
    parser.add_argument("--watchdog", type=float, default=line["watchdog_s"])
    parser.add_argument("--nobody", type=float, default=line["connect_s"])
    options = parser.parse_args()
    token = os.environ.get("PA10_TOKEN", "")
    simulator = Simulator(options.dir, options.port, options.controller, token, (options.watchdog, options.nobody))
    signal.signal(signal.SIGTERM, simulator.stop)
    signal.signal(signal.SIGINT, simulator.stop)
    sys.stdout.write(f"listening on 127.0.0.1:{simulator.network.port}\n")
    sys.stdout.flush()
    sys.setswitchinterval(SWITCH_S)
    first_in_line()
    simulator.run()


if __name__ == "__main__":
    main()
