"""The PUMA 560's driver: translates commands in SI units into lines of its controller's protocol."""

import contextlib
from collections.abc import Callable
from typing import Any

import numpy as np

from robots.kit.arms.boxes import added_boxes
from robots.kit.arms.chain import Joints, Matrix
from robots.kit.arms.commands import motion_of
from robots.kit.arms.described import chain
from robots.kit.arms.follow import Follower
from robots.kit.arms.jogs import JOG_M_S, JOG_RAD_S, joint_velocity, tool_velocity
from robots.kit.arms.knots import knots_of
from robots.kit.arms.motions import Motion
from robots.kit.arms.pose import numbers
from robots.kit.clock import Limit
from robots.kit.contract.errors import ControllerRefused, HardwareFault, MotionHeld, OutOfWorkspace
from robots.kit.contract.session import Moves, OnStage, Outcome, Permit, RobotState, Session, Trace
from robots.kit.contract.values import number
from robots.kit.description import load
from robots.kit.drivers.arm_tasks import KINDS, ArmTasks
from robots.kit.drivers.permits import until_at_rest, until_held
from robots.kit.drivers.puma import protocol as wire
from robots.kit.drivers.puma.checks import check, planner_for
from robots.kit.drivers.puma.protocol import BAUDS, End, Error, Flag, Frame, Instruction, Mode, State
from robots.kit.drivers.puma.spec import FAULT, MODES, NOT_CALIBRATED, VALVE
from robots.kit.drivers.serial_line import SerialLine, open_port

POLL_S = 0.05
LOOK_S = 0.01  # between two looks for rest after a hold
REST_S = 2.0
CALIBRATED_S = 20.0
JOG_S = 0.1  # between two velocities
JOG_LOOK_S = 0.2  # between two states of a jog
OUTSIDE = (Error.OUT_OF_RANGE, Error.IN_BOX)
LOST = "A joint left its range, or did not follow its reference."
UNKNOWN_ZEROS = "The arm does not know the zeros of its joints before it is calibrated."
Numbers = tuple[int, ...]


class Driver(Session):
    """A `robots.kit.contract.session.Session`. `address` is a port or a pyserial URL.

    `settings` may contain `baud` and more forbidden `boxes`.
    """

    opened = staticmethod(open_port)

    def __init__(self, address: str, settings: dict[str, Any], trace: Trace | None = None) -> None:
        super().__init__(address, settings, trace)
        self._description, self._chain = load("puma"), chain("puma")
        line = self._description["line"]
        self._fresh_s = float(line["fresh_s"])
        baud = min(BAUDS, key=lambda one: abs(one - float(settings.get("baud") or line["baud"])))
        self.line = SerialLine(wire, address, baud, int(line["resends"]), trace, self.clock, self.opened)
        self._rest: Joints | None = None
        self.tasks = ArmTasks(self, "puma", lambda: planner_for(settings), lambda: self.line.holds)

    def connect(self) -> RobotState:
        """Open the line, ask for the state, and tell the controller which boxes staff have added."""
        planner_for(self.settings)  # the planner is created before the first command, because that is slow
        self.line.open()
        self._begin()
        self.tasks.begin()
        state = self.state()
        self.tasks.look()
        return state

    def _begin(self) -> None:
        self.line.boot = None
        controller = self.line.status()
        self.line.boot = controller.boot
        self.line.start_after(controller.newest)
        self._instruct(Instruction.BOX, ())
        for box in added_boxes(self.settings):
            self._instruct(Instruction.BOX, tuple(map(wire.hundredths_mm, (*box.low, *box.high))))

    def close(self) -> None:
        """Close the port."""
        self.line.close()

    def state(self) -> RobotState:
        """Ask the controller for its state."""
        return self._take(self.line.status())

    def _take(self, arm: State) -> RobotState:
        calibrated, lost = Flag.CALIBRATED in arm.flags, Flag.FAULT in arm.flags
        mode = MODES[arm.mode]
        if arm.mode == Mode.IDLE and not calibrated:
            mode = NOT_CALIBRATED
        state = self.keep(
            RobotState(
                self.clock.monotonic(), arm.joints, numbers(self._chain.forward(np.array(arm.joints))),
                arm.mode != Mode.IDLE, calibrated and not lost, LOST if lost else "", mode=FAULT if lost else mode,
                values={VALVE: float(Flag.CLOSED in arm.flags)},
            )
        )  # fmt: skip
        return self.tasks.observe(state)

    def _instruct(
        self, what: Instruction, values: Numbers, permit: Permit | None = None,
        on_sent: Callable[[], None] | None = None,
    ) -> int:  # fmt: skip
        """Send an instruction; return its number. Raises as `SerialLine.instruct`."""
        return self.line.instruct(lambda seq: Frame(what, seq, values), permit, on_sent)

    def _latest_clock(self) -> int:
        """Return the controller's clock after which an instruction of now must not begin.

        A reply that was late itself makes this earlier, never later.
        """
        assert self.line.newest is not None, "a state was asked for when the line was opened"
        reply, at = self.line.newest
        ahead = self.clock.monotonic() - at + self._fresh_s
        return (wire.clock_of(reply) + round(ahead / wire.TICK_S)) % wire.CLOCK

    def execute(self, kind: str, args: dict[str, Any], permit: Permit, on_stage: OnStage) -> Outcome:
        """Run one command to its end."""
        check(kind, args, self.settings, self._latest)
        try:
            return self._carry_out(kind, args, permit, on_stage)
        finally:
            self.tasks.report(on_stage)

    def _carry_out(self, kind: str, args: dict[str, Any], permit: Permit, on_stage: OnStage) -> Outcome:
        if kind == "noop":
            permit()
            return Outcome({}, self._latest)
        if kind in KINDS:
            return self.tasks.execute(kind, args, permit, on_stage)
        if kind.startswith("jog_"):
            self.state()  # which tells the controller's clock too
            what, velocity = self._velocity(kind, args)
            return self._jog(what, lambda _: velocity, JOG_LOOK_S, permit, on_stage)
        if kind == "follow":
            follower = Follower(self._tool(self.state()), JOG_M_S, JOG_RAD_S)
            return self._jog(
                Instruction.JOG_TOOL, lambda free: self._towards(follower, self.steered(args), free), 0.0, permit,
                on_stage,
            )  # fmt: skip
        if kind == "gripper":
            return self._grip(number(args, "closed") >= 0.5, args, permit, on_stage)
        state = self._go(motion_of("puma", kind, args), permit, on_stage)
        self.tasks.look()
        return Outcome(dict(args), state)

    def _grip(self, closed: bool, args: dict[str, Any], permit: Permit, on_stage: OnStage) -> Outcome:
        free = until_held(permit, lambda: self.line.holds)
        self.line.status()
        self._instruct(Instruction.GRIP, (self._latest_clock(), int(closed)), free, lambda: on_stage("sent"))
        on_stage("acknowledged")
        self.clock.sleep(float(self._description["gripper"]["seconds"]))
        state = self.state()
        self.tasks.gripped(closed, state)
        self.tasks.look()
        return Outcome(dict(args), state)

    def _go(self, motion: Motion, permit: Permit, on_stage: OnStage) -> RobotState:
        """Move and wait for rest."""
        before = self.line.holds
        free = until_held(permit, lambda: self.line.holds)
        self._take(self.line.status())
        seq = self._instruct(*self._asked(motion), free, lambda: on_stage("sent"))
        on_stage("acknowledged")
        arm = self._until_rest(seq, permit, self._on_moving(motion, on_stage))
        state = self._take(arm)
        if state.fault:
            raise HardwareFault(state.fault)
        if arm.end == End.REFUSED:
            fault = OutOfWorkspace if arm.why in OUTSIDE else ControllerRefused
            raise fault(f"The arm's controller refused: {wire.ERROR_TEXT[arm.why]}.")
        if arm.end == End.HELD:
            if self.line.holds == before:
                raise HardwareFault("The controller held the motion by itself.")
            raise MotionHeld("The motion was stopped on its way.")
        self._rest = np.array(arm.joints)
        return state

    def _asked(self, motion: Motion) -> tuple[Instruction, Numbers]:
        """Return the instruction for a motion, which must begin soon."""
        share = round(1000 * (float(self._description["motion"]["scale"]) if motion.scale is None else motion.scale))
        head = self._latest_clock(), share
        if motion.pose is None:
            return Instruction.JOINTS, (*head, *map(wire.thousandths, motion.joints))
        x, y, z, roll, pitch, yaw = motion.pose
        what = Instruction.LINE if motion.straight else Instruction.POSE
        return what, (*head, *map(wire.hundredths_mm, (x, y, z)), *map(wire.thousandths, (yaw, pitch, roll)))

    def _on_moving(self, motion: Motion, on_stage: OnStage) -> Callable[[], None]:
        """Return what tells viewers the path, once the arm was seen to begin it."""
        assert self._latest is not None, "it was asked for before the motion was sent"
        here = np.array(self._latest.joints)

        def tell() -> None:
            path = planner_for(self.settings).expected(motion, here, np.zeros_like(here))
            knots = None if path is None else knots_of(path)
            if knots is not None:
                on_stage(Moves(knots, self.clock.monotonic()))

        return tell

    def _until_rest(self, seq: int, permit: Permit, on_moving: Callable[[], None]) -> State:
        limit_s = float(self._description["motion"]["limit_s"])
        allowed, moved = Limit(self.clock, limit_s), False
        while True:
            self.clock.sleep(POLL_S)
            arm = self.line.status()
            self._take(arm)
            if arm.mode == Mode.MOVING and arm.motion == seq and not moved:
                moved = True
                on_moving()
            if arm.mode == Mode.IDLE and (arm.motion == seq or Flag.FAULT in arm.flags):
                return arm
            permit()
            if allowed.over:
                self.hold()
                raise HardwareFault(f"The motion did not end within {limit_s:g} s and was held.")

    def _jog(
        self, what: Instruction, velocity: Callable[[Permit], Numbers], look_s: float, permit: Permit,
        on_stage: OnStage,
    ) -> Outcome:  # fmt: skip
        """Send the velocity of each moment again and again while `permit` allows it.

        `velocity` gets a permit that a hold ends, too. The state is asked for so often (s). A jog needs it seldom, and
        a slow line has time for no more.
        """
        free = until_held(permit, lambda: self.line.holds)
        sent: Callable[[], None] | None = lambda: on_stage("sent")  # noqa: E731 - for the first one only
        self._rest = None  # a reset after a jog must not return to its start
        looked = Limit(self.clock, 0.0)
        try:
            while True:
                paced = Limit(self.clock, JOG_S)
                self._instruct(what, (self._latest_clock(), *velocity(free)), free, sent)
                if sent is not None:
                    on_stage("acknowledged")
                sent = None
                if looked.over:
                    looked = Limit(self.clock, look_s)
                    state = self.state()
                    if state.fault:
                        raise HardwareFault(state.fault)
                self.clock.sleep(max(0.0, paced.remaining))
        finally:
            self._instruct(Instruction.HOLD, ())

    def _velocity(self, kind: str, args: dict[str, Any]) -> tuple[Instruction, Numbers]:
        if kind == "jog_joints":
            return Instruction.JOG_JOINTS, tuple(map(wire.thousandths, joint_velocity(self._chain, args)))
        return Instruction.JOG_TOOL, _twist(tool_velocity(args))

    def _towards(self, follower: Follower, hand: dict[str, Any], permit: Permit) -> Numbers:
        """Return the velocity from the newest state towards the hand; it may move the gripper. Raises HandLost."""
        assert self._latest is not None, "it was asked for before"
        twist = follower.twist(self._tool(self._latest), hand)
        if (closed := follower.grip(hand)) is not None:
            self._instruct(Instruction.GRIP, (self._latest_clock(), int(closed)), permit)
            self.tasks.gripped(closed, self._latest)
        return _twist(twist)

    def _tool(self, state: RobotState) -> Matrix:
        """Return the tool's pose (4 x 4)."""
        return self._chain.forward(np.array(state.joints))

    def hold(self) -> RobotState:
        """Send HOLD past everything else and wait until the set-point rests."""
        self._instruct(Instruction.HOLD, ())
        return until_at_rest(self.state, self.clock, REST_S, "The arm", LOOK_S)

    def recover(self, permit: Permit) -> RobotState:
        """Soft reset: reset the controller, calibrate, return to the previous position."""
        permit()
        self.line.reach()
        back = self._rest
        self.line.boot = None
        self._instruct(Instruction.RESET, (), permit)
        self._begin()
        self._calibrate(permit)
        if back is not None:
            with contextlib.suppress(OutOfWorkspace):  # the way is blocked, which is not a fault: the arm stays
                self._go(Motion(tuple(back)), permit, lambda _: None)
        return self.state()

    def _calibrate(self, permit: Permit) -> None:
        self._instruct(Instruction.CALIBRATE, (self._latest_clock(),), permit)
        limit = Limit(self.clock, CALIBRATED_S)
        while self.state().moving:
            if limit.over:
                raise HardwareFault("The arm did not finish its calibration.")
            self.clock.sleep(POLL_S)
        if not self.state().ready:
            raise HardwareFault(f"The arm was not calibrated. {UNKNOWN_ZEROS}")


def _twist(velocity: Joints) -> Numbers:
    """Return a velocity of the tool (m/s along, rad/s about x y z) as the wire tells it."""
    return (*map(wire.hundredths_mm, velocity[:3]), *map(wire.thousandths, velocity[3:]))
