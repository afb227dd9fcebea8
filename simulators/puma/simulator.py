"""The simulated PUMA 560: plant, control loop in 2 ms steps, controller and line."""

import os
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from robots.kit.clock import TIMER, Limit, Timer
from robots.kit.drivers.puma import protocol as wire
from simulators.common.arm.cameras import SharedScene
from simulators.common.arm.controllers import ComputedTorque
from simulators.common.arm.fallen import LOOK_EVERY, Fallen
from simulators.common.arm.kept_scene import keep_scene, restore_scene
from simulators.common.arm.pace import Pace
from simulators.common.arm.reference_judge import ReferenceJudge
from simulators.common.arm.rest import Rest
from simulators.common.arm.scene import Judge
from simulators.common.arm.setpoint import Reference
from simulators.common.faults import FaultBoard, serve
from simulators.common.fork import Fork, fork
from simulators.common.journal import Journal, Note
from simulators.common.nonvolatile import keep, restore
from simulators.common.serial_line import Arrived, OpenLine
from simulators.common.threads import names, record_deaths
from simulators.puma.cell import bricks, things
from simulators.puma.controller import BOOTS, Controller
from simulators.puma.courses import Courses
from simulators.puma.errors import errors_of, kept_seed
from simulators.puma.mishaps import Mishaps
from simulators.puma.motions import Motions
from simulators.puma.plant import Plant

SHARE_EVERY = 20  # steps between two positions for the cameras and for the next start: 40 ms
JUDGE_EVERY = 5
SLIP_STEPS = 150
STOP_S = 2.0  # for a motion at the end of the simulator
PUSHING = ("disturb", "slip", "power_cycle", "limit_hit")  # the faults for which the loop runs
OBJECTS = tuple(things())
LIMBS = ("upper_arm", "forearm", "lower_forearm", "wrist", "tool", "left_pad", "right_pad")
BOLTED = {("upper_arm", "the base")}
Planner = Callable[[Note], Courses]  # makes a planner that writes into the journal what happens to it
Cameras = Callable[
    [Path, int], None
]  # the process of the cameras of the scene in this folder; the number of its parent


class Simulator:
    """All parts. Its line is open already; `open` opens the rest to other programs.

    `seed`: of the cell's hidden errors; None for the one that its folder keeps.
    """

    def __init__(
        self, folder: Path, planner: Planner, opened: OpenLine, seed: int | None = None, clock: Timer = TIMER,
        real: Timer = TIMER,
    ) -> None:  # fmt: skip
        folder.mkdir(parents=True, exist_ok=True)
        self._folder, self._clock, self._state = folder, clock, folder / "state.json"
        self.faults, self.journal = FaultBoard(), Journal(folder / "journal.jsonl", real)
        courses = planner(self.journal.note)
        errors = errors_of(kept_seed(folder, seed))
        self.plant = Plant(qpos=restore_scene(folder / "scene.npy"), errors=errors)
        self._mishaps, self._fallen = Mishaps(self.faults, self.plant), Fallen(self.plant, self.journal.note)
        self._measured = self.plant.measured()
        self._torques = ComputedTorque("puma")
        self._judge, self.nearest = Judge(self.plant.model, "puma", LIMBS, BOLTED), (Judge.FAR, "")
        self.steps, self._slips = 0, 0  # steps; steps during which the gripper slips
        self.error = 0.0  # greatest distance of a joint from its reference (rad)
        closed, last_boot = restore(self._state, _closed, False)
        self.motions = Motions(courses, self._measured.q, self.journal.note, clock, closed)
        boot = (last_boot + 1) % BOOTS
        self._keep_state(boot)
        self.controller = Controller(self.motions, self.faults, self.journal.note, boot, self._keep_state, clock)
        still = np.zeros_like(self._measured.q)
        first = Reference(self._measured.q, still, still, int(closed))
        self._references = ReferenceJudge(courses.planner.limits, self.journal.note, first)
        self._rest, self._pace = Rest(clock), Pace(clock)
        self._shared = SharedScene(folder / "scene.mem", self.plant.model.nq, begin=True)
        self._shared.write(self.plant.qpos)
        self.line = opened(folder / "tty", self.faults, partial(self.journal.note, "refused"))
        self._cameras: Fork | None = None
        self._stopping = False

    def open(self, cameras: Cameras | None = None) -> None:
        """Open cameras and faults to other programs. No thread may run yet."""
        record_deaths(self.journal)
        if cameras is not None:
            self._cameras = fork(partial(cameras, self._folder, os.getpid()))
            self._clock.spawn(partial(self._mind, self._cameras), "cameras")
        serve(self._folder / "faults", self.faults, self.status)

    def _mind(self, process: Fork) -> None:
        """Wait for the end of the cameras' process; raise then, which ends the simulator."""
        status = process.wait()
        if not self._stopping:
            raise RuntimeError(f"the process of the cameras ended with status {status}")

    def _keep_state(self, boot: int) -> None:
        keep(self._state, boot, {"closed": self.motions.closed})

    def _keep_scene(self) -> None:
        qpos = self.plant.qpos
        self._shared.write(qpos)
        keep_scene(self._folder / "scene.npy", qpos)  # whoever kills the simulator finds the arm here again

    def status(self) -> dict[str, Any]:
        """Return counters and positions, for tests."""
        arm, now = self.motions, self._measured
        return {
            "counts": dict(self.journal.counts),
            "q": now.q.tolist(),
            "speed": float(np.max(np.abs(now.v))),
            "reference": self._references.newest.q.tolist(),
            "threads": names(),
            "moving": arm.moving,
            "mode": arm.mode.name.lower(),
            "calibrated": arm.calibrated,
            "fault": arm.fault,
            "opening": now.opening,
            "boot": self.controller.boot,
            "late": self._pace.late,
            "worst_ms": round(1000 * self._pace.worst, 2),
            "worst_error": round(self.error, 6),
            "steps": self.steps,
            "nearest": self.nearest,
            "objects": {name: self.plant.place(name).round(5).tolist() for name in (*OBJECTS, "tip")},
        }

    def run(self) -> None:
        """Control at 500 Hz until stopped; while nothing moves only the line is served."""
        self.motions.planning.begin()
        receiver = wire.Receiver(wire.INSTRUCTIONS, lambda seq: self.controller.refuse_broken(seq, self.line.send))
        self._pace.begin()
        while not self._stopping:
            self._pace.wait()
            self._serve(receiver, self.line.exchange())
            self._one()
            if self._rest.reached(self._busy(), lambda: self.plant.qpos):
                self._tidy()
                self._keep_scene()
                while not self._busy():
                    self._serve(receiver, self.line.poll(busy=False))
                self._rest.wake()
                self._pace.begin()
        self._end()

    def _serve(self, receiver: wire.Receiver, arrived: Arrived) -> None:
        """Answer the lines that came."""
        for frame in receiver.feed(arrived.data):
            self.controller.handle(frame, self.line.send)
        self.controller.advance()

    def _busy(self) -> bool:
        """Return whether the loop has work although nothing moves."""
        pushed = any(self.faults.value(verb) for verb in PUSHING) or self._mishaps.busy
        return pushed or self.motions.busy or self._fallen.any() or self._stopping

    def _one(self) -> None:
        self.steps += 1
        measured = self._measured = self.plant.measured()
        if self.motions.closed != self._references.newest.gripper:
            self._keep_state(self.controller.boot)
        reference = self.motions.step(measured.q)
        if self.motions.moving:
            self.error = max(self.error, float(np.max(np.abs(reference.q - measured.q))))
        self._references.look(reference, self.motions.fault)
        self._spoil()
        torque = self._torques.torques(reference.q, reference.v, reference.a, measured)
        self._slips = max(0, self._slips - 1)
        self.plant.step(torque, 0 if self._slips else reference.gripper)
        if self.steps % JUDGE_EVERY == 0 and self.motions.moving:
            self.nearest = min(self.nearest, self._judge.nearest(self.plant.data))
        if self.steps % LOOK_EVERY == 0:
            self._tidy()
        if self.steps % SHARE_EVERY == 0:
            self._keep_scene()

    def _tidy(self) -> None:
        if not self.faults.value("vanish"):  # which takes a brick out of the cell
            self._fallen.look(bricks())

    def _spoil(self) -> None:
        """Disturb the arm (N m on J1) and let an object slip, as the fault board says."""
        self._mishaps.step()
        self.plant.disturbance[0] = self.faults.value("disturb")
        if self.faults.take("slip"):
            self._slips = SLIP_STEPS
            self.journal.note("slip")

    def stop(self, *_: object) -> None:
        """End the loop; the arm rests first."""
        self._stopping = True

    def _end(self) -> None:
        self.motions.hold("the simulator ends")
        limit = Limit(self._clock, STOP_S)
        while self.motions.moving and not limit.over:
            self._pace.wait()
            self._one()
        self._keep_scene()
        self._keep_state(self.controller.boot)
        self.motions.planning.close()
        self.motions.courses.close()
        if self._cameras is not None:
            self._cameras.terminate()


def _closed(stored: Mapping[str, Any]) -> bool:
    return bool(stored["closed"])
