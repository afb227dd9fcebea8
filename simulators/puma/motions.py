"""What the controller does with the arm: plans, motions, jogs, holds, faults. The control loop alone calls it."""

from collections.abc import Callable
from functools import partial
from math import degrees, radians

import numpy as np

from robots.kit.arms.chain import Joints
from robots.kit.arms.path import Path
from robots.kit.arms.planner import Refused
from robots.kit.arms.zones import Box
from robots.kit.clock import Timer
from robots.kit.description import load
from robots.kit.drivers.puma.protocol import CLOCK, TICK_S, End, Error, Mode, too_late
from simulators.common.arm.position_guard import PositionGuard
from simulators.common.arm.scene import STEP_S
from simulators.common.arm.setpoint import Reference, SetPoint
from simulators.common.journal import Note
from simulators.puma.courses import Courses
from simulators.puma.planning import PlanningThread

LAG_RAD = radians(5.0)  # farther from its reference a joint does not follow it
GRIP_S = 1.0  # after which the fingers rest, whatever they hold
REFUSALS = {"range": Error.OUT_OF_RANGE, "box": Error.IN_BOX}
MOVES = (Mode.MOVING, Mode.JOGGING, Mode.CALIBRATING)
Question = Callable[[Joints], Path]  # plans from rest at these joints (rad)


class Motions:
    """The newest motion, and the reference that comes of it.

    `seq` is the sequence number of the newest motion, `end` how it ended, `why` the reason of a refusal; `number`
    counts motions. `q` (rad): where the arm stands at the start; `closed`: the gripper's valve.
    """

    def __init__(self, courses: Courses, q: Joints, note: Note, clock: Timer, closed: bool = False) -> None:
        self.courses, self._note, self._timer = courses, note, clock
        self.planning = PlanningThread(clock)
        self._set = SetPoint(courses.planner, q, float(load("puma")["line"]["dead_man_s"]))
        self._guard = PositionGuard(courses.planner, q)
        self.measured = q
        self._ticks, self._now = 0, 0.0  # steps of the control loop, and its time in s
        self._gripped = 0  # the step until which the fingers may move
        self.number, self.seq, self.closed, self.mode = 0, 0, closed, Mode.IDLE
        self.power_on()

    def power_on(self) -> None:
        """Forget everything but the place and the valve; the arm rests where it is."""
        self.planning.ask(None)
        if self.mode != Mode.IDLE:
            self._note("end", motion=self.number, seq=self.seq, end="power")
        self.mode, self.seq, self.end, self.why = Mode.IDLE, 0, End.NONE, Error.NONE
        self.fault = self.calibrated = False
        self._question: Question | None = None  # what is planned now
        self._latest = 0  # the clock after which that must not begin
        self._set.stand(self.measured)
        self.forbid(())

    @property
    def clock(self) -> int:
        """Return the controller's clock; it goes on while the power is off, as one with a battery."""
        return int(self._timer.monotonic() / TICK_S) % CLOCK

    @property
    def moving(self) -> bool:
        """Return whether the set-point moves."""
        return self._set.moving

    @property
    def busy(self) -> bool:
        """Return whether the control loop has work."""
        return self.mode != Mode.IDLE or self._set.moving or self._ticks < self._gripped

    # what the wire asks for

    def plan(self, seq: int, question: Question, latest: int, calibrates: bool = False) -> None:
        """Plan a motion, and begin it if `latest` has not passed by then."""
        self._begin(seq, Mode.CALIBRATING if calibrates else Mode.PLANNING)
        self._question, self._latest = question, latest
        self._ask(question)

    def _ask(self, question: Question) -> None:
        self.planning.ask(partial(question, self._set.q.copy()))

    def jog(self, seq: int, tool: bool, values: Joints) -> None:
        """Drive by velocities, see `SetPoint`; they begin a motion, or are of the one that is jogged already."""
        if self._set.drive(tool, values, self._now):
            self._begin(seq, Mode.JOGGING)
            self._note("motion", motion=self.number, seq=seq, velocity="tool" if tool else "joints")

    def _begin(self, seq: int, mode: Mode) -> None:
        self.number += 1
        self.seq, self.mode, self.end, self.why = seq, mode, End.NONE, Error.NONE

    def grip(self, closed: bool) -> None:
        """Set the gripper's valve."""
        self.closed, self._gripped = closed, self._ticks + round(GRIP_S / STEP_S)
        self._note("gripper", closed=int(closed))

    def hold(self, why: str) -> None:
        """Come to rest with the hardest braking; what is only planned never begins."""
        self._note("hold", why=why, mode=self.mode.name.lower(), at=round(self._now, 4))
        if self._question is not None:
            self._question = None
            self.planning.ask(None)
            self._finish(End.HELD)
        elif self.mode in MOVES:
            self._set.brake(self._now)
            self.mode = Mode.HOLDING
            if not self._set.moving:
                self._rest()

    def forbid(self, boxes: tuple[Box, ...]) -> None:
        """Keep out of these boxes beside the arm's own; what is planned now is planned again."""
        self.boxes = boxes
        self.courses.forbid(boxes)
        self._set.planner = self.courses.planner
        self._guard.accept(self.courses.planner, self.measured)
        self._set.look_again()
        if self._question is not None:
            self._ask(self._question)

    def fail(self, why: str) -> None:
        """Brake because of a fault, which only a reset ends; the motors hold."""
        self.fault = True
        self._note("fault", why=why)
        self.hold("fault")

    # what the loop calls

    def step(self, measured: Joints) -> Reference:
        """Return the reference 2 ms later; checks the measured position (rad)."""
        self._ticks += 1
        self._now = self._ticks * STEP_S
        self.measured = measured
        if self._question is not None:
            self._take_answer()
        if self._set.step(self._now):
            self._rest()
        if not self.fault and (why := self._guard.violation(measured) or self._lag(measured)):
            self.fail(why)
        return Reference(self._set.q, self._set.v, self._set.a, int(self.closed))

    def _take_answer(self) -> None:
        """Begin what has been planned by now."""
        answer = self.planning.answer()
        if answer is None:
            return
        self._question = None
        if isinstance(answer, Refused):
            self._finish(End.REFUSED, REFUSALS.get(answer.code, Error.BUSY))
        elif too_late(self._latest, self.clock):
            self._note("late", seq=self.seq)
            self._finish(End.REFUSED, Error.TOO_LATE)
        else:
            self.mode = Mode.MOVING if self.mode == Mode.PLANNING else self.mode
            self._set.take(answer, self._now)
            target, _, _ = answer.at(answer.seconds)
            self._note("motion", motion=self.number, seq=self.seq, target=[round(float(v), 6) for v in target],
                       seconds=round(answer.seconds, 4), calibrates=self.mode == Mode.CALIBRATING)  # fmt: skip

    def _rest(self) -> None:
        self._note("rest", motion=self.number, seq=self.seq, at=round(self._now, 4))
        if self.mode == Mode.CALIBRATING:
            self.calibrated = True
        self._finish(End.HELD if self.mode == Mode.HOLDING else End.DONE)

    def _finish(self, end: End, why: Error = Error.NONE) -> None:
        self.mode, self.end, self.why = Mode.IDLE, end, why
        self._note("end", motion=self.number, seq=self.seq, end=end.name.lower(), why=why.name.lower())

    def _lag(self, measured: Joints) -> str:
        """Return which joint does not follow the reference, empty if each does."""
        lags = np.abs(self._set.q - measured)
        worst = int(np.argmax(lags))
        if lags[worst] <= LAG_RAD:
            return ""
        name = self.courses.planner.chain.names[worst]
        return f"{name} is {degrees(lags[worst]):.1f} degrees away from its reference"
