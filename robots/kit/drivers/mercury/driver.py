"""The Mercury arm's driver: translates commands in SI units into instructions on the serial line."""

from collections.abc import Callable
from math import degrees, hypot, radians
from typing import Any

from robots.kit.clock import Limit
from robots.kit.contract.errors import HardwareFault, MotionHeld, RobotError
from robots.kit.contract.session import OnStage, Outcome, Permit, RobotState, Session, Trace
from robots.kit.contract.values import number
from robots.kit.description import load
from robots.kit.drivers.mercury import protocol as wire
from robots.kit.drivers.mercury.checks import check, check_target
from robots.kit.drivers.mercury.protocol import Flag, Frame, Instruction, Mode, Reply
from robots.kit.drivers.mercury.scara import scara
from robots.kit.drivers.permits import until_at_rest, until_held
from robots.kit.drivers.serial_line import SerialLine, open_port

POLL_S = 0.2
REST_S = 2.0  # a hold must have brought the arm to rest by then
ARRIVED_M = 0.0006  # rounding of binary32 on the wire and of joints to a pose
SQUARE_RAD = 0.003
STOPPED = "The motion was stopped on its way."


class Driver(Session):
    """A `robots.kit.contract.session.Session`. `address` is a port or a pyserial URL."""

    opened = staticmethod(open_port)

    def __init__(self, address: str, settings: dict[str, Any], trace: Trace | None = None) -> None:
        super().__init__(address, settings, trace)
        self._description = load("mercury")
        self._arm = scara(self._description)
        resends = int(self._description["line"]["resends"])
        self.line = SerialLine(wire, address, wire.BAUD, resends, trace, self.clock, self.opened)
        self._rest_pose: tuple[float, ...] | None = None

    def connect(self) -> RobotState:
        """Open the line and ask for the state; speed and boot number are set from the answer."""
        self.line.open()
        self.line.boot = None
        controller = self.line.status()
        self.line.boot = controller.boot
        self.line.start_after(controller.newest_seq)
        state = self._take(controller)
        if not state.moving:
            self._rest_pose = self._rest_pose or state.pose
        if state.ready and not state.moving:
            self._set_speed()
        return state

    def close(self) -> None:
        """Close the port."""
        self.line.close()

    def state(self) -> RobotState:
        """Ask the controller for its state."""
        return self._take(self.line.status())

    def _take(self, controller: wire.ControllerState) -> RobotState:
        return self._told(
            controller.joints,
            moving=controller.mode != Mode.IDLE,
            ready=bool(controller.flags & Flag.CALIBRATED) and not controller.flags & Flag.LIMIT,
            fault="A limit switch is hit." if controller.flags & Flag.LIMIT else "",
        )

    def _told(
        self, joints: tuple[float, float, float, float], moving: bool, ready: bool, fault: str = ""
    ) -> RobotState:
        q = radians(joints[0]), radians(joints[1]), joints[2] / 1000, radians(joints[3])
        return self.keep(RobotState(self.clock.monotonic(), q, self._arm.forward(q), moving, ready, fault))

    def execute(self, kind: str, args: dict[str, Any], permit: Permit, on_stage: OnStage) -> Outcome:
        """Run one command to its end."""
        check(kind, args, self.settings, self._latest or self.state())
        if kind == "noop":
            permit()
            return Outcome({}, self._latest)
        if kind == "speed":
            self.settings = {**self.settings, "speed": number(args, "speed")}
            self._set_speed(permit, lambda: on_stage("sent"))
            on_stage("acknowledged")
            return Outcome(dict(args), self._latest)
        if kind == "bury":
            bed = number(args, "number")
            self.line.instruct(lambda seq: wire.scalar(Instruction.BURY, seq, bed), permit, lambda: on_stage("sent"))
            on_stage("acknowledged")
            return Outcome(dict(args), self._latest)
        if kind == "air":
            seconds = float(args.get("seconds", self._description["air"]["burst_s"]))
            x, y = (self._latest or self.state()).pose[:2]
            sent = {"seconds": seconds, "x": round(x, 4), "y": round(y, 4)}
            return self._run(lambda seq: wire.scalar(Instruction.AIR, seq, seconds), sent, permit, on_stage, 3.0)
        if kind == "jog":
            return self._jog(number(args, "dx"), number(args, "dy"), permit, on_stage)
        return self._go(self._target(kind, args), permit, on_stage)

    def _jog(self, dx: float, dy: float, permit: Permit, on_stage: OnStage) -> Outcome:
        """Move by short steps while `permit` allows each one, or to the edge of the sand."""
        sand, share = self._description["sand"], float(self._description["jog"]["step"]) / hypot(dx, dy)
        sent: dict[str, Any] = {"steps": 0}
        go_on = until_held(permit, lambda: self.line.holds)
        while True:
            go_on()
            x, y, z = (self._latest or self.state()).pose[:3]
            to_x = min(max(x + share * dx, sand["x"][0]), sand["x"][1])
            to_y = min(max(y + share * dy, sand["y"][0]), sand["y"][1])
            if hypot(to_x - x, to_y - y) < ARRIVED_M:
                return Outcome({**sent, "edge": True}, self._latest)
            self._go((to_x, to_y, z), go_on, on_stage)
            sent["steps"] += 1

    def _target(self, kind: str, args: dict[str, Any]) -> tuple[float, float, float]:
        x, y, z = (self._latest or self.state()).pose[:3]
        arm = self._description["arm"]
        match kind:
            case "move":
                return number(args, "x"), number(args, "y"), z
            case "up":
                return x, y, float(arm["up"])
            case "down":
                return x, y, float(arm["down"])
            case _:
                home = self._description["home"]
                return home["x"], home["y"], float(arm["up"])

    def _go(self, target: tuple[float, float, float], permit: Permit, on_stage: OnStage) -> Outcome:
        check_target(self._description, *target)
        x, y, z = target
        outcome = self._run(
            lambda seq: wire.move_xyz(seq, x * 1000, y * 1000, z * 1000),
            {"x": x, "y": y, "z": z}, permit, on_stage, float(self._description["motion"]["limit_s"]),
        )  # fmt: skip
        state = outcome.state
        assert state is not None
        off = max(abs(a - b) for a, b in zip(state.pose[:3], target, strict=True))
        if off > ARRIVED_M:
            raise HardwareFault(f"The arm stopped {off * 1000:.1f} mm away from its target.")
        self._rest_pose = state.pose
        return outcome

    def _run(self, build: Any, sent: dict[str, Any], permit: Permit, on_stage: OnStage, limit_s: float) -> Outcome:
        before = self.line.holds
        seq = self.line.instruct(build, permit, lambda: on_stage("sent"))
        on_stage("acknowledged")
        limit = Limit(self.clock, limit_s)
        while True:
            end = self.line.end_of(seq, POLL_S)
            if end is not None:
                return Outcome(sent, self._ended(end))
            controller = self.line.status()
            state = self._take(controller)
            if state.fault:
                raise HardwareFault(state.fault)
            if not state.moving and not wire.newer(seq, controller.newest_seq):
                # DONE was lost on the line, or follows this state
                end = self.line.end_of(seq, POLL_S)
                if end is not None:
                    return Outcome(sent, self._ended(end))
                if self.line.holds != before:
                    raise MotionHeld(STOPPED)
                return Outcome(sent, state)
            if limit.over:
                self.line.instruct(lambda s: Frame(Instruction.HOLD, s), None)
                raise HardwareFault(f"The motion did not end within {limit_s:g} s and was held.")

    def _ended(self, end: Frame) -> RobotState:
        state = self._told(wire.unpack_end(end.payload), moving=False, ready=True)
        if end.id == Reply.HELD:
            if self.line.holds == 0:
                raise HardwareFault("The controller held the motion by itself.")
            raise MotionHeld(STOPPED)
        return state

    def hold(self) -> RobotState:
        """Send HOLD past everything else and wait until the set-point rests."""
        self.line.instruct(lambda seq: Frame(Instruction.HOLD, seq), None)
        return until_at_rest(self.state, self.clock, REST_S, "The arm")

    def recover(self, permit: Permit) -> RobotState:
        """Soft reset (section 6.7): reset, recalibrate, return to the previous position."""
        permit()
        self.line.reach()
        back = self._rest_pose
        self.line.boot = None
        self.line.instruct(lambda seq: Frame(Instruction.RESET, seq), permit)
        self.line.boot = self.line.status().boot
        self._finish(self.line.instruct(lambda seq: Frame(Instruction.CALIBRATE, seq), permit), 10.0)
        self._set_speed(permit)
        theta = float(self._description["arm"]["theta_deg"])
        if abs(degrees(self.state().pose[3]) - theta) > degrees(SQUARE_RAD):
            seq = self.line.instruct(lambda s: wire.scalar(Instruction.MOVE_THETA, s, theta), permit)
            self._finish(seq, 10.0)
        if back is not None:
            try:
                self._go((back[0], back[1], back[2]), permit, lambda _: None)
            except RobotError as error:
                if not isinstance(error, HardwareFault):
                    raise
                raise HardwareFault(f"The arm was reset but did not return: {error}") from error
        return self.state()

    def _finish(self, seq: int, limit_s: float) -> None:
        limit = Limit(self.clock, limit_s)
        while self.line.end_of(seq, POLL_S) is None:
            if not self.state().moving:
                return
            if limit.over:
                raise HardwareFault("The controller did not finish its own reset.")

    def _set_speed(self, permit: Permit | None = None, on_sent: Callable[[], None] = lambda: None) -> None:
        low, high = self._description["motion"]["speed_range"]
        speed = float(self.settings.get("speed") or self._description["motion"]["speed"])
        speed_mm_s = min(max(speed, low), high) * 1000
        self.line.instruct(lambda seq: wire.scalar(Instruction.SPEED, seq, speed_mm_s), permit, on_sent)
