"""The simulated museum arm: plant, controller, application, network and cameras, in 2 ms steps."""

import os
import threading
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from robots.kit.arms.planner import Refused
from robots.kit.clock import TIMER, Timer, poll
from robots.kit.drivers.pa10.courses import Courses
from robots.kit.drivers.pa10.protocol import VELOCITIES, ArmState, Request
from robots.kit.files import replace_text
from simulators.common.arm.cameras import SharedScene
from simulators.common.arm.fallen import LOOK_EVERY, Fallen
from simulators.common.arm.kept_scene import keep_scene, restore_scene
from simulators.common.arm.pace import Pace
from simulators.common.arm.plant import Measured
from simulators.common.arm.position_guard import why_outside
from simulators.common.arm.reference_judge import ReferenceJudge
from simulators.common.arm.rest import Rest
from simulators.common.arm.setpoint import Reference
from simulators.common.faults import FaultBoard, serve
from simulators.common.fork import Fork, fork
from simulators.common.journal import Journal, Note
from simulators.common.tcp import TcpListener
from simulators.common.threads import names, record_deaths
from simulators.pa10 import cameras
from simulators.pa10.application import DEAD_MAN_S, Application
from simulators.pa10.client import Order
from simulators.pa10.controllers import CONTROLLERS
from simulators.pa10.plant import Plant
from simulators.pa10.scene import BLOCKS, STEP_S, Judge
from simulators.pa10.server import Network
from simulators.pa10.store import ProgramStore

SHARE_EVERY = 20  # steps between two positions for the cameras: 40 ms
JUDGE_EVERY = 5
SLIP_STEPS = 150
LOOK_S = 0.1  # between two looks of the watchdog
OBJECTS = tuple(name for name, _, _ in BLOCKS)
Planner = Callable[[Note], Courses]  # makes a planner that writes into the journal what happens to it


class Simulator:
    """Plant, controller, application and network. `watchdog`: the longest silence of an owner, of anybody (s)."""

    def __init__(
        self, folder: Path, planner: Planner, controller: str, token: str, watchdog: tuple[float, float],
        clock: Timer = TIMER, real: Timer = TIMER,
    ) -> None:  # fmt: skip
        folder.mkdir(parents=True, exist_ok=True)
        self._folder, self._clock = folder, clock
        self.faults, self.journal = FaultBoard(), Journal(folder / "journal.jsonl", real)
        self._courses = planner(self.journal.note)
        self.plant = Plant(qpos=restore_scene(folder / "scene.npy"))
        self._controller = CONTROLLERS[controller]()
        self._judge, self.nearest = Judge(self.plant.model), (Judge.FAR, "")
        self.boot, self.steps = 0, 0
        self.error = 0.0  # distance of a joint from its reference (rad)
        self._fallen = Fallen(self.plant, self.journal.note)
        self._slips = 0  # steps during which the gripper slips
        self._rest, self._pace = Rest(clock), Pace(clock)
        self._measured = self.plant.measured()
        still = np.zeros_like(self._measured.q)
        first = Reference(self._measured.q, still, still, 0)
        self._references = ReferenceJudge(self._courses.planner.limits, self.journal.note, first)
        self.store = ProgramStore(folder / "programs.json")
        self._begin("power on", error=why_outside(self._courses.planner, self._measured.q))
        self._shared = SharedScene(folder / "scene.mem", self.plant.model.nq, begin=True)
        self._shared.write(self.plant.qpos)
        self.network = Network(self, self.faults, self.journal.note, token, clock=clock)
        self._watchdog = watchdog
        self._cameras: Fork | None = None
        self._ending: threading.Thread | None = None
        self._running = True

    def open(self, port: int) -> int:
        """Open line (0: any port), cameras and faults to other programs; return the port. No thread may run yet."""
        record_deaths(self.journal)
        self._cameras = fork(partial(cameras.run, self._folder, os.getpid()))
        listener = TcpListener(port)
        self.network.listen(listener)
        self._clock.spawn(partial(self._mind, self._cameras), "cameras")
        serve(self._folder / "faults", self.faults, self.status)
        replace_text(self._folder / "tty", f"127.0.0.1:{listener.port}\n")
        return listener.port

    def _mind(self, process: Fork) -> None:
        """Wait for the end of the cameras' process; raise then, which ends the simulator."""
        status = process.wait()
        if self._ending is None:
            raise RuntimeError(f"the process of the cameras ended with status {status}")

    def _begin(self, why: str, error: str = "", extra: tuple[Any, ...] = ()) -> None:
        self.boot += 1
        gripper = int(self._measured.opening < 0.03)
        self.app = Application(
            self._courses, self._measured.q.copy(), self.journal.note, self.store, gripper, error, extra, self._clock
        )
        self.journal.note("application", boot=self.boot, why=why)

    def begin_again(self, why: str) -> None:
        """Restart the control application once the arm rests; a range error stays."""
        self.app.hold()
        while self.app.moving and self._running:
            self._clock.sleep(STEP_S)
        self._begin(why, self.app.error, self.app.extra)
        self._rest.wake()

    # what the network calls

    def order(self, request: Request) -> Order:
        """Return what answers a request: of this application, and as of now."""
        if request.letter == "w":
            return lambda: self.app.letter()
        if request.letter == "s":
            return lambda: self.state().encode()
        return partial(self._take, self.app, request, self.app.hold_count, self._clock.monotonic())

    def _take(self, app: Application, request: Request, asked: int, arrived: float) -> str:
        """Let the control loop run before and after a request, whose planning may take time."""
        if request.letter in VELOCITIES and self._clock.monotonic() - arrived > DEAD_MAN_S:
            raise Refused("busy", f"this velocity waited for more than {DEAD_MAN_S:g} s behind other lines; repeat it")
        self._rest.wake()
        try:
            return app.take(request, asked)
        finally:
            self._rest.wake()

    def hold(self) -> None:
        """Bring the arm to rest."""
        self.app.hold()
        self._rest.wake()

    def keep(self, number: int, text: str) -> None:
        """Replace a stored program."""
        self.store.replace(number, text)

    def wait(self, seconds: float) -> str:
        """Wait for rest; return the answer to `W`."""
        return self.app.wait_for_rest(seconds)

    def state(self) -> ArmState:
        """Return the answer to `s`."""
        app, now = self.app, self._measured
        with app.unchanged:  # a range error is also a hold; nobody must read the hold without the error
            return ArmState(
                app.mode, app.motion, app.end, self.boot, app.program, app.step_of, app.gripper, now.opening,
                app.moving, tuple(now.q), tuple(now.v), tuple(now.torque), app.note[:80],
            )  # fmt: skip

    def status(self) -> dict[str, Any]:
        """Return counters and positions, for tests."""
        return {
            "counts": dict(self.journal.counts),
            "q": self._measured.q.tolist(),
            "speed": float(np.max(np.abs(self._measured.v))),
            "reference": self._references.newest.q.tolist(),
            "threads": names(),
            "moving": self.app.moving,
            "mode": str(self.app.mode),
            "boot": self.boot,
            "late": self._pace.late,
            "worst_ms": round(1000 * self._pace.worst, 2),
            "worst_error": round(self.error, 6),
            "steps": self.steps,
            "nearest": self.nearest,
            "objects": {
                name: self.plant.place(name).round(4).tolist() for name in ("red", "yellow", "blue", "green", "tip")
            },
        }

    def run(self) -> None:
        """Control at 500 Hz until stopped; late steps are made up for, and an arm at rest pauses the loop."""
        watch(self.network, *self._watchdog, self.begin_again, self._clock)
        pace = self._pace
        pace.begin()
        while self._running:
            pace.wait()
            self._one()
            if self._rest.reached(self._busy(), lambda: self.plant.qpos):
                self._fallen.look(OBJECTS)
                self._shared.write(self.plant.qpos)
                self._rest.last(self._busy)  # not while something lies beside the table
                pace.begin()
        keep_scene(self._folder / "scene.npy", self.plant.qpos)
        if self._ending is not None:
            self._ending.join()

    def _busy(self) -> bool:
        """Return whether the loop has work although nothing moves."""
        pushed = any(self.faults.value(verb) for verb in ("disturb", "slip", "restart"))
        return pushed or self.app.busy or self._fallen.any() or not self._running

    def _one(self) -> None:
        self.steps += 1
        measured: Measured = self.plant.measured()
        reference = self.app.step(measured.q, measured.v)
        self._measured = measured
        if self.app.moving:
            self.error = max(self.error, float(np.max(np.abs(reference.q - measured.q))))
        self._references.look(reference, bool(self.app.error))
        self._spoil()
        torque = self._controller.torques(reference.q, reference.v, reference.a, measured)
        self._slips = max(0, self._slips - 1)
        self.plant.step(torque, 0 if self._slips else reference.gripper)
        if self.steps % JUDGE_EVERY == 0 and self.app.moving:
            self.nearest = min(self.nearest, self._judge.nearest(self.plant.data))
        if self.steps % LOOK_EVERY == 0:
            self._fallen.look(OBJECTS)
        if self.steps % SHARE_EVERY == 0:
            self._shared.write(self.plant.qpos)

    def _spoil(self) -> None:
        """Disturb the arm (N m on S1) and let an object slip, as the fault board says."""
        self.plant.disturbance[0] = self.faults.value("disturb")
        if self.faults.take("restart"):
            again = partial(self.network.restart, "asked for by a fault verb", self.begin_again)
            self._clock.spawn(again, "restart")
        if self.faults.take("slip"):
            self._slips = SLIP_STEPS
            self.journal.note("slip")

    def stop(self, *_: object) -> None:
        """End the loop; the arm rests first."""
        self._ending = self._clock.spawn(self._end, "end")

    def _end(self) -> None:
        self.app.hold()
        poll(lambda: not self.app.moving, self._clock, 2.0, STEP_S)
        self._running = False
        self._rest.wake()
        self.network.close()
        self._courses.close()
        if self._cameras is not None:
            self._cameras.terminate()


def watch(
    network: Network, silence_s: float, nobody_s: float, again: Callable[[str], None], clock: Timer = TIMER
) -> None:
    """Restart the application if the owner is silent for so long, or if nobody connects (figure 4 b)."""

    def look() -> None:
        while True:
            clock.sleep(LOOK_S)
            network.watch(silence_s, nobody_s, again)

    clock.spawn(look, "watchdog")
