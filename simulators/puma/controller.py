"""The controller's end of the wire: reads instructions, checks them, answers.

It never executes one sequence number twice, accepts HOLD at any moment under any number, and begins nothing whose
latest clock has passed.
"""

from collections import OrderedDict
from collections.abc import Callable
from functools import partial
from math import radians

import numpy as np

from robots.kit.arms.chain import Joints
from robots.kit.arms.zones import Box
from robots.kit.clock import Timer
from robots.kit.description import load
from robots.kit.drivers.puma import protocol as wire
from robots.kit.drivers.puma.protocol import Error, Flag, Frame, Instruction, Mode, Reply, State
from simulators.common.faults import FaultBoard
from simulators.common.journal import Note
from simulators.puma.courses import Numbers, motion_of, velocity_of
from simulators.puma.motions import Motions

BOOTS = 1 << 16
RESET_S = 0.3  # after the power came back; nothing is heard meanwhile
REMEMBERED = 32  # stored answers, repeated for the same number
MOST_BOXES = 32
COARSE_RAD = radians(0.3)  # of the potentiometers, which alone are known before the calibration
Send = Callable[[Frame], None]


class Controller:
    """One controller, from power-on. `switched_on` stores a new boot number before it is used."""

    def __init__(
        self, motions: Motions, faults: FaultBoard, note: Note, boot: int, switched_on: Callable[[int], None],
        clock: Timer,
    ) -> None:  # fmt: skip
        self.motions, self._faults, self._note = motions, faults, note
        self._switched_on, self._clock = switched_on, clock
        self._silence_s = float(load("puma")["line"]["silence_s"])
        self.boot = boot
        self._power_on()

    def _power_on(self) -> None:
        self.newest: int | None = None
        self._answers: OrderedDict[int, tuple[int, Frame]] = OrderedDict()  # code and answer
        self._quiet_until, self._heard_at = 0.0, self._clock.monotonic()

    def restart(self) -> None:
        """Lose power and start again: the arm stays where it is, the valve too."""
        boot = (self.boot + 1) % BOOTS
        self._switched_on(boot)  # before anybody can see it
        self.boot = boot
        self._power_on()
        self.motions.power_on()
        self._quiet_until = self._clock.monotonic() + RESET_S
        self._note("power_on", boot=boot)

    def _deaf(self) -> bool:
        return self._clock.monotonic() < self._quiet_until or bool(self._faults.value("awol"))

    def refuse_broken(self, seq: int, send: Send) -> None:
        """Answer the number of a line with a wrong checksum; nothing else of it is used."""
        if not self._deaf():
            send(self._nak(seq, Error.CHECKSUM))

    def handle(self, frame: Frame, send: Send) -> None:
        """Answer one line with the right checksum."""
        if self._deaf():
            return
        self._heard_at = self._clock.monotonic()
        if frame.id == Instruction.STATUS:
            send(self._nak(frame.seq, Error.BAD_NUMBERS) if frame.numbers else self._state(frame.seq))
            return
        fresh = self.newest is None or wire.newer(frame.seq, self.newest)
        code, answer = self._answers.get(frame.seq, (0, None))
        if not fresh and answer is not None and (frame.id != Instruction.HOLD or code == frame.id):
            send(answer)
            return
        if not fresh and frame.id != Instruction.HOLD:  # a hold is accepted under any number
            send(self._nak(frame.seq, Error.STALE_SEQUENCE))
            return
        if fresh:
            self.newest = frame.seq
            self._answers.pop(frame.seq, None)  # of a number that comes again after 256
        error = self._begin(frame)
        answer = self._nak(frame.seq, error) if error else Frame(Reply.ACK, frame.seq, (self.boot, self.motions.clock))
        self._answers.setdefault(frame.seq, (frame.id, answer))
        while len(self._answers) > REMEMBERED:
            self._answers.popitem(last=False)
        if self._faults.value("awol"):
            return
        send(answer)
        if self._faults.take("double_ack"):
            send(answer)

    def _begin(self, frame: Frame) -> Error | None:
        """Carry out an instruction; return why not."""
        if frame.id not in wire.INSTRUCTIONS:
            return Error.UNKNOWN_CODE
        try:
            numbers = frame.checked()
        except wire.FormError:
            return Error.BAD_NUMBERS
        match frame.id:
            case Instruction.HOLD:
                self.motions.hold("asked for")
                return None
            case Instruction.RESET:
                self.restart()
                self.newest, self._quiet_until = frame.seq, 0.0
                return None
            case Instruction.BOX:
                return self._forbid(numbers)
        error = self._why_not(frame.id, numbers[0])
        if error == Error.TOO_LATE:
            self._note("late", seq=frame.seq)
        if error is None:
            self._move(frame, numbers)
        return error

    def _forbid(self, numbers: Numbers) -> Error | None:
        boxes = self.motions.boxes
        if not numbers:
            self.motions.forbid(())
            return None
        if len(boxes) >= MOST_BOXES:
            return Error.OUT_OF_RANGE
        corners = np.array(numbers).reshape(2, 3) / 100_000
        low, high = corners.min(axis=0), corners.max(axis=0)
        box = Box(f"box {len(boxes) + 1}", tuple(low.tolist()), tuple(high.tolist()))
        self.motions.forbid((*boxes, box))
        return None

    def _why_not(self, what: int, latest: int) -> Error | None:
        """Return why the arm or its gripper must not move."""
        arm = self.motions
        if arm.fault:
            return Error.FAULT
        if not arm.calibrated and what != Instruction.CALIBRATE:
            return Error.NOT_CALIBRATED
        if wire.too_late(latest, arm.clock):
            return Error.TOO_LATE
        free = arm.mode == Mode.IDLE or what == Instruction.GRIP
        return None if free or (arm.mode == Mode.JOGGING and what in wire.JOGS) else Error.BUSY

    def _move(self, frame: Frame, numbers: Numbers) -> None:
        arm = self.motions
        if frame.id == Instruction.GRIP:
            arm.grip(bool(numbers[1]))
        elif frame.id == Instruction.CALIBRATE:
            arm.plan(frame.seq, arm.courses.index_path, numbers[0], calibrates=True)
        elif frame.id in wire.JOGS:
            arm.jog(frame.seq, frame.id == Instruction.JOG_TOOL, velocity_of(frame.id, numbers))
        else:
            motion = motion_of(frame.id, numbers)
            arm.plan(frame.seq, partial(arm.courses.motion_path, motion), numbers[0])

    def advance(self) -> None:
        """Do what nobody asks for: hold where the host is silent, and what the fault board says."""
        if self._faults.take("power_cycle"):
            self.restart()
        if self._faults.take("limit_hit") and self.motions.moving:
            self.motions.fail("a joint reached the switch at the end of its range")
        silent = self._clock.monotonic() - self._heard_at > self._silence_s
        if silent and self.motions.mode not in (Mode.IDLE, Mode.HOLDING):
            self.motions.hold("silence")

    @property
    def joints(self) -> Joints:
        """Return the joints that the controller tells (rad)."""
        q = self.motions.measured
        return q if self.motions.calibrated else np.round(q / COARSE_RAD) * COARSE_RAD

    def _state(self, seq: int) -> Frame:
        arm, flags = self.motions, Flag.NONE
        for flag, is_set in ((Flag.CALIBRATED, arm.calibrated), (Flag.FAULT, arm.fault), (Flag.CLOSED, arm.closed)):
            flags |= flag if is_set else Flag.NONE
        state = State(
            self.boot, arm.clock, arm.mode, flags, self.newest or 0, arm.seq, arm.end, arm.why,
            tuple(self.joints.tolist()),
        )  # fmt: skip
        return state.frame(seq)

    def _nak(self, seq: int, error: Error) -> Frame:
        return Frame(Reply.NAK, seq, (self.boot, self.motions.clock, error))
