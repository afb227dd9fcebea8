"""The arm's controller: takes instructions off the line, moves the body, answers.

It keeps the same limits as the driver, refuses motion until it was calibrated, takes HOLD
while it moves, and never executes one sequence number twice.
"""

import time
from collections import OrderedDict
from collections.abc import Callable
from math import degrees, isfinite, radians
from typing import Any

from robots.description import scara
from robots.drivers.mercury import protocol as wire
from robots.drivers.mercury.protocol import Error, Flag, Frame, Instruction, Mode, Reply
from robots.motion.scara import OutOfReach
from simulators.common.faults import FaultBoard
from simulators.common.journal import Journal
from simulators.mercury.arm import AT_REST_M, Body, Pose

CALIBRATE_S = 1.2
RESET_S = 0.3
Send = Callable[[Frame], None]


class Controller:
    """One controller, from power-on."""

    def __init__(
        self,
        description: dict[str, Any],
        body: Body,
        blow: Callable[[float, float, float], None],
        faults: FaultBoard,
        journal: Journal,
        boot: int,
    ) -> None:
        self._arm = scara(description)
        self._description = description
        self.body = body
        self._blow = blow
        self._faults = faults
        self._journal = journal
        self.boot = boot
        self._power_on()

    def _power_on(self) -> None:
        self.calibrated = False
        self.limit = False
        self.newest = 0
        self.mode = Mode.IDLE
        self._answers: OrderedDict[int, Frame] = OrderedDict()
        self._running: int | None = None
        self._until = 0.0
        self._speed = float(self._description["motion"]["speed"])
        self._quiet_until = 0.0
        self._settling = False

    def restart(self) -> None:
        """Lose power and come back: nothing is remembered but where the arm stands."""
        self.boot = self.boot % 255 + 1
        self.body.line = None
        self._power_on()
        self._quiet_until = time.monotonic() + RESET_S
        self._journal.note("power_on", boot=self.boot)

    def handle(self, frame: Frame, send: Send) -> None:
        """Answer one instruction."""
        if time.monotonic() < self._quiet_until or self._faults.value("awol"):
            return
        if frame.id == Instruction.STATUS:
            send(self._state(frame.seq))
            return
        known = self._answers.get(frame.seq)
        if known is not None and not wire.newer(frame.seq, self.newest):
            send(known)
            return
        if self.newest and not wire.newer(frame.seq, self.newest):
            send(self._nak(frame.seq, Error.STALE_SEQUENCE))
            return
        self.newest = frame.seq
        error = self._begin(frame)
        answer = self._nak(frame.seq, error) if error else Frame(Reply.ACK, frame.seq, bytes((self.boot,)))
        self._answers[frame.seq] = answer
        while len(self._answers) > 32:
            self._answers.popitem(last=False)
        if self._faults.value("awol"):
            return
        send(answer)
        if self._faults.take("double_ack"):
            send(answer)

    def _begin(self, frame: Frame) -> Error | None:
        try:
            match frame.id:
                case Instruction.HOLD:
                    self._hold()
                    return None
                case Instruction.RESET:
                    self.restart()
                    self.newest = frame.seq
                    self._quiet_until = 0.0
                    return None
                case Instruction.SPEED:
                    return self._set_speed(wire.unpack_scalar(frame.payload) / 1000)
                case Instruction.CALIBRATE:
                    return self._calibrate(frame.seq)
                case Instruction.MOVE_XYZ:
                    x, y, z = (value / 1000 for value in wire.unpack_xyz(frame.payload))
                    return self._move(frame.seq, Pose(x, y, z, self.body.setpoint.theta))
                case Instruction.MOVE_THETA:
                    now = self.body.setpoint
                    theta = radians(wire.unpack_scalar(frame.payload))
                    return self._move(frame.seq, Pose(now.x, now.y, now.z, theta))
                case Instruction.AIR:
                    return self._air(frame.seq, wire.unpack_scalar(frame.payload))
        except wire.FrameError:
            return Error.BAD_LENGTH
        return Error.UNKNOWN_INSTRUCTION

    def _hold(self) -> None:
        self._journal.note("hold", moving=self.body.moving)
        if self.body.moving:
            self.body.brake()
            self.mode = Mode.HOLDING

    def _set_speed(self, speed: float) -> Error | None:
        low, high = self._description["motion"]["speed_range"]
        if not (isfinite(speed) and low - 1e-6 <= speed <= high + 1e-6):
            return Error.OUT_OF_RANGE
        self._speed = speed
        return None

    def _calibrate(self, seq: int) -> Error | None:
        if self.mode != Mode.IDLE:
            return Error.BUSY
        self.mode, self._running = Mode.CALIBRATING, seq
        self._until = time.monotonic() + CALIBRATE_S
        self._journal.note("calibrate", seq=seq)
        return None

    def _ready(self) -> Error | None:
        if not self.calibrated:
            return Error.NOT_CALIBRATED
        if self.limit:
            return Error.LIMIT_SWITCH
        return Error.BUSY if self.mode != Mode.IDLE else None

    def _move(self, seq: int, target: Pose) -> Error | None:
        if not all(isfinite(v) for v in target.as_tuple()):
            return Error.OUT_OF_RANGE
        sand = self._description["sand"]
        slack = 1e-4
        inside = (
            sand["x"][0] - slack <= target.x <= sand["x"][1] + slack
            and sand["y"][0] - slack <= target.y <= sand["y"][1] + slack
        )
        z = max(0.0, target.z) if target.z > -slack else target.z
        if z < self._arm.q3.high + slack:
            z = min(z, self._arm.q3.high)
        try:
            self._arm.inverse(target.x, target.y, z, target.theta)
        except OutOfReach:
            return Error.OUT_OF_RANGE
        if not inside:
            return Error.OUT_OF_RANGE
        error = self._ready()
        if error:
            return error
        target.z = min(max(z, 0.0), self._arm.q3.high)
        drift = self._faults.value("drift") / 1000
        target.x, target.y = target.x + drift, target.y + drift
        self.mode, self._running = Mode.MOVING, seq
        self.body.start(target, self._speed)
        self._settling = True
        self._journal.note("motion", seq=seq, target=[round(v, 5) for v in target.as_tuple()], speed=self._speed)
        return None

    def _air(self, seq: int, seconds: float) -> Error | None:
        low, high = self._description["air"]["burst_range_s"]
        if not (isfinite(seconds) and low <= seconds <= high + 1e-6):
            return Error.OUT_OF_RANGE
        error = self._ready()
        if error:
            return error
        if self.body.setpoint.z > 0.001:
            return Error.OUT_OF_RANGE
        self.mode, self._running = Mode.BLOWING, seq
        self._until = time.monotonic() + seconds
        self._journal.note("burst", seq=seq, seconds=seconds)
        x, y, _, _ = self.body.setpoint.as_tuple()
        self._blow(x * 1000, y * 1000, seconds)
        return None

    def advance(self, now: float, send: Send) -> None:
        """Let time pass up to `now`; send what has ended."""
        if self._faults.take("power_cycle"):
            self.restart()
        self.body.advance_to(now)
        if self._faults.take("limit_hit") and self.body.moving:
            self.body.brake()
            self.limit = True
            self.mode = Mode.HOLDING
        ended = self.body.ended
        if ended is not None:
            self.body.ended = None
            self._journal.note("rest", seq=self._running, braked=ended.braking)
            self._finish(Reply.HELD if ended.braking else Reply.DONE, send)
        if self.mode in (Mode.CALIBRATING, Mode.BLOWING) and now >= self._until:
            self.calibrated = self.calibrated or self.mode == Mode.CALIBRATING
            if self.mode == Mode.CALIBRATING:
                self.limit = False
            self._finish(Reply.DONE, send)
        if self._settling and not self.body.moving and self.body.amplitude() < AT_REST_M:
            self._settling = False
            self._journal.note("settled")

    def _finish(self, reply: Reply, send: Send) -> None:
        seq, self._running, self.mode = self._running, None, Mode.IDLE
        if seq is not None and not self._faults.value("awol"):
            send(wire.pack_end(reply, seq, self.boot, self.joints()))

    @property
    def busy(self) -> bool:
        """Tell whether time matters now (else the line may sleep)."""
        return self.mode != Mode.IDLE or self._settling

    def joints(self) -> tuple[float, float, float, float]:
        """Return the joints of the set-point: deg, deg, mm, deg."""
        try:
            q = self._arm.inverse(*self.body.setpoint.as_tuple())
        except OutOfReach:  # between two poses a hair past a limit
            q = self._arm.branches(*self.body.setpoint.as_tuple())[0]
        return degrees(q[0]), degrees(q[1]), q[2] * 1000, degrees(q[3])

    def _state(self, seq: int) -> Frame:
        flags = (Flag.CALIBRATED if self.calibrated else Flag.NONE) | (Flag.LIMIT if self.limit else Flag.NONE)
        return wire.pack_state(seq, wire.ControllerState(self.boot, self.mode, flags, self.newest, self.joints()))

    def _nak(self, seq: int, error: Error) -> Frame:
        return Frame(Reply.NAK, seq, bytes((self.boot, error)))
