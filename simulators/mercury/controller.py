"""The arm's controller: receives instructions, moves the body, answers.

It checks the same limits as the driver, refuses motion until it was calibrated, accepts HOLD while it moves, and never
executes one sequence number twice.
"""

from collections import OrderedDict
from collections.abc import Callable
from math import degrees, radians
from typing import Any

from robots.kit.clock import TIMER, Timer
from robots.kit.drivers.mercury import protocol as wire
from robots.kit.drivers.mercury.protocol import Error, Flag, Frame, Instruction, Mode, Reply
from simulators.common.faults import FaultBoard
from simulators.common.journal import Journal
from simulators.common.nonvolatile import BOOTS
from simulators.mercury.arm import AT_REST_M, Body, Pose
from simulators.mercury.workspace import Workspace

CALIBRATE_S = 1.2
RESET_S = 0.3
REMEMBERED = 32  # stored answers, repeated for the same number
Send = Callable[[Frame], None]


class Controller:
    """One controller, from power-on."""

    def __init__(
        self,
        description: dict[str, Any],
        body: Body,
        blow: Callable[[float, float, float], None],
        bury: Callable[[int], None],
        faults: FaultBoard,
        journal: Journal,
        boot: int,
        switched_on: Callable[[int], None] = lambda boot: None,
        clock: Timer = TIMER,
    ) -> None:
        """`blow` (mm, mm, s) moves the sand, `bury` makes the bed of a number.

        `switched_on` stores a new boot number before it is used.
        """
        self._space = Workspace(description)
        self._description = description
        self.body = body
        self._blow = blow
        self._bury = bury
        self._faults = faults
        self._journal = journal
        self._switched_on = switched_on
        self._clock = clock
        self.boot = boot
        self._power_on()

    def _power_on(self) -> None:
        self.calibrated = False
        self.limit = False
        self.newest: int | None = None
        self.mode = Mode.IDLE
        self._answers: OrderedDict[int, Frame] = OrderedDict()
        self._running: int | None = None
        self._since = self._until = 0.0
        self._speed = float(self._description["motion"]["speed"])
        self._quiet_until = 0.0
        self._settling = False

    def restart(self) -> None:
        """Lose power and start again: only the arm's position is kept."""
        if self.mode == Mode.BLOWING:
            self._end_burst(self._clock.monotonic(), "power")
        boot = (self.boot + 1) % BOOTS
        self._switched_on(boot)  # before anybody can see it
        self.boot = boot
        self.body.line = None
        self._power_on()
        self._quiet_until = self._clock.monotonic() + RESET_S
        self._journal.note("power_on", boot=self.boot)

    def _deaf(self) -> bool:
        return self._clock.monotonic() < self._quiet_until or bool(self._faults.value("awol"))

    def refuse_broken(self, seq: int, send: Send) -> None:
        """Answer the number of a frame with a wrong checksum; nothing else of it is used."""
        if not self._deaf():
            send(wire.pack_nak(seq, self.boot, Error.CHECKSUM))

    def handle(self, frame: Frame, send: Send) -> None:
        """Answer one frame with the right checksum."""
        if self._deaf():
            return
        if frame.id == Instruction.STATUS:
            send(self._nak(frame.seq, Error.BAD_LENGTH) if frame.payload else self._state(frame.seq))
            return
        fresh = self.newest is None or wire.newer(frame.seq, self.newest)
        if not fresh and (known := self._answers.get(frame.seq)):
            send(known)
            return
        if not fresh and frame.id != Instruction.HOLD:  # a hold is accepted under any number
            send(self._nak(frame.seq, Error.STALE_SEQUENCE))
            return
        if fresh:
            self.newest = frame.seq
        error = self._begin(frame, send)
        answer = self._nak(frame.seq, error) if error else wire.pack_ack(frame.seq, self.boot)
        self._answers[frame.seq] = answer
        while len(self._answers) > REMEMBERED:
            self._answers.popitem(last=False)
        if self._faults.value("awol"):
            return
        send(answer)
        if self._faults.take("double_ack"):
            send(answer)

    def _begin(self, frame: Frame, send: Send) -> Error | None:
        if frame.id not in wire.INSTRUCTIONS:
            return Error.UNKNOWN_INSTRUCTION
        try:
            values = wire.numbers(frame)
        except wire.NumberError:
            return Error.OUT_OF_RANGE
        except wire.FrameError:
            return Error.BAD_LENGTH
        here = self.body.setpoint
        match frame.id:
            case Instruction.HOLD:
                self._hold(send)
                return None
            case Instruction.RESET:
                self.restart()
                self.newest = frame.seq
                self._quiet_until = 0.0
                return None
            case Instruction.SPEED:
                return self._set_speed(values[0] / 1000)
            case Instruction.BURY:
                return self._renew(values[0])
            case Instruction.CALIBRATE:
                return self._calibrate(frame.seq)
            case Instruction.MOVE_XYZ:
                x, y, z = (value / 1000 for value in values)
                return self._move(frame.seq, self._space.line_end(here, x, y, z))
            case Instruction.MOVE_THETA:
                return self._move(frame.seq, self._space.turn_end(here, radians(values[0])))
            case _:
                return self._air(frame.seq, values[0])

    def _hold(self, send: Send) -> None:
        self._journal.note("hold", moving=self.body.moving)
        if self.body.moving:
            self.body.brake()
            self.mode = Mode.HOLDING
        elif self.mode == Mode.BLOWING:
            self._end_burst(self._clock.monotonic(), "held")
            self._finish(Reply.HELD, send)

    def _set_speed(self, speed: float) -> Error | None:
        low, high = self._description["motion"]["speed_range"]
        if not low - 1e-6 <= speed <= high + 1e-6:
            return Error.OUT_OF_RANGE
        self._speed = speed
        return None

    def _renew(self, number: float) -> Error | None:
        if number < 1 or number != int(number):
            return Error.OUT_OF_RANGE
        self._journal.note("bury", number=int(number))
        self._bury(int(number))
        return None

    def _calibrate(self, seq: int) -> Error | None:
        if self.mode != Mode.IDLE:
            return Error.BUSY
        self.mode, self._running = Mode.CALIBRATING, seq
        self._until = self._clock.monotonic() + CALIBRATE_S
        self._journal.note("calibrate", seq=seq)
        return None

    def _ready(self) -> Error | None:
        if not self.calibrated:
            return Error.NOT_CALIBRATED
        if self.limit:
            return Error.LIMIT_SWITCH
        return Error.BUSY if self.mode != Mode.IDLE else None

    def _move(self, seq: int, target: Pose | None) -> Error | None:
        if target is None:
            return Error.OUT_OF_RANGE
        error = self._ready()
        if error:
            return error
        drift = self._faults.value("drift") / 1000
        target.x, target.y = target.x + drift, target.y + drift
        self.mode, self._running = Mode.MOVING, seq
        self.body.start(target, self._speed)
        self._settling = True
        self._journal.note("motion", seq=seq, target=[round(v, 5) for v in target.as_tuple()], speed=self._speed)
        return None

    def _air(self, seq: int, seconds: float) -> Error | None:
        low, high = self._description["air"]["burst_range_s"]
        if not low - 1e-6 <= seconds <= high + 1e-6:
            return Error.OUT_OF_RANGE
        error = self._ready()
        if error:
            return error
        if self.body.setpoint.z > 0.001:
            return Error.OUT_OF_RANGE
        self.mode, self._running = Mode.BLOWING, seq
        self._since = self._clock.monotonic()
        self._until = self._since + seconds
        self._journal.note("burst", seq=seq, seconds=seconds)
        return None

    def _end_burst(self, now: float, why: str) -> None:
        """Close the valve; the sand moves according to the time it was open."""
        seconds = min(now, self._until) - self._since
        self._journal.note("burst_end", seq=self._running, seconds=round(seconds, 4), why=why)
        x, y, _, _ = self.body.setpoint.as_tuple()
        self._blow(x * 1000, y * 1000, seconds)

    def advance(self, now: float, send: Send) -> None:
        """Let time pass up to `now`; send the ends of motions and bursts."""
        if self._faults.take("power_cycle"):
            self.restart()
        self.body.advance_to(now)
        if self.body.moving and (why := self._space.passed(self.body.setpoint)):
            self._journal.note("passed", why=why)
        if self._faults.take("limit_hit") and self.body.moving:
            self.body.brake()
            self.limit = True
            self.mode = Mode.HOLDING
        ended = self.body.last_line
        if ended is not None:
            self.body.last_line = None
            self._journal.note("rest", seq=self._running, braked=ended.braking)
            self._finish(Reply.HELD if ended.braking else Reply.DONE, send)
        if self.mode in (Mode.CALIBRATING, Mode.BLOWING) and now >= self._until:
            self.calibrated = self.calibrated or self.mode == Mode.CALIBRATING
            if self.mode == Mode.CALIBRATING:
                self.limit = False
            else:
                self._end_burst(now, "done")
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
        """Return whether time matters now; otherwise the line may sleep."""
        return self.mode != Mode.IDLE or self._settling

    def joints(self) -> tuple[float, float, float, float]:
        """Return the joints of the set-point: deg, deg, mm, deg."""
        q = self._space.joints(self.body.setpoint)
        return degrees(q[0]), degrees(q[1]), q[2] * 1000, degrees(q[3])

    def _state(self, seq: int) -> Frame:
        flags = (Flag.CALIBRATED if self.calibrated else Flag.NONE) | (Flag.LIMIT if self.limit else Flag.NONE)
        state = wire.ControllerState(self.boot, self.mode, flags, self.newest or 0, self.joints())
        return wire.pack_state(seq, state)

    def _nak(self, seq: int, error: Error) -> Frame:
        return wire.pack_nak(seq, self.boot, error)
