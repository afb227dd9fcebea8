"""The museum arm's driver: translates commands in SI units into lines of its controller's protocol."""

from collections.abc import Callable
from math import degrees
from typing import Any

import numpy as np

from robots.kit.arms.boxes import added_boxes
from robots.kit.arms.chain import Joints, Matrix
from robots.kit.arms.described import chain, posture
from robots.kit.arms.follow import Follower
from robots.kit.arms.jogs import JOG_M_S, JOG_RAD_S, joint_velocity, tool_velocity
from robots.kit.arms.knots import knots_of
from robots.kit.arms.pose import numbers
from robots.kit.clock import TIMER, Limit, Timer
from robots.kit.contract.errors import ControllerRefused, HardwareFault, MotionHeld, OutOfWorkspace
from robots.kit.contract.session import Moves, OnStage, Outcome, Permit, Progress, RobotState, Session, Trace
from robots.kit.contract.values import number
from robots.kit.description import load
from robots.kit.drivers.arm_tasks import KINDS, ArmTasks
from robots.kit.drivers.pa10.checks import check, planner_for, request_of, steps_of
from robots.kit.drivers.pa10.line import ANSWER_S, CHECKED_S, ArmLine
from robots.kit.drivers.pa10.protocol import LONGEST_PROGRAM_S, MOTIONS, ArmState, End, Mode, Request
from robots.kit.drivers.pa10.spec import PLANNED_S
from robots.kit.drivers.pa10.units import joint_request, motion_of
from robots.kit.drivers.permits import until_at_rest, until_held
from robots.kit.drivers.stream import open_stream

POLL_S = 0.05
LOOK_S = 0.01  # between two looks for rest after a hold
REST_S = 2.0
STILL_RAD_S = 0.02  # below this a measured joint counts as at rest
SETTLED_S = 5.0  # the longest wait for an arm that was pushed
JOG_S = 0.08  # between two velocities; the controller drops one after 0.25 s
GRIP_S = 3.0
STRAIGHT = "l"  # begins at rest only; the motion that it replaces has left the arm moving
TAUGHT = 9000  # the number under which a program is stored before it is executed


def _words(arm: ArmState) -> str:
    """Return the controller's register as the paper writes it, and the step of a running program."""
    register = arm.mode.replace("_", " ")
    return f"{register}: program {arm.program}, step {arm.step}" if arm.program else register


def _sentence(note: str) -> list[str]:
    """Return the controller's note as a sentence, if there is one.

    For a program sent by this driver the note is without its number.
    """
    words = note.replace(f"program {TAUGHT}", "the program")
    return [f"{words[0].upper()}{words[1:]}."] if words else []


class Driver(Session):
    """A `robots.kit.contract.session.Session`. `settings` may contain `epoch`, `token` and more forbidden `boxes`."""

    opened = staticmethod(open_stream)
    real: Timer = TIMER  # for answers: a controller plans no faster where `clock` runs faster than the machine's

    def __init__(self, address: str, settings: dict[str, Any], trace: Trace | None = None) -> None:
        super().__init__(address, settings, trace)
        self._description, self._chain = load("pa10"), chain("pa10")
        epoch, token = int(settings.get("epoch", 0)), str(settings.get("token", ""))
        self.line = ArmLine(address, epoch, token, trace, self.real, self.opened)
        self._boot: int | None = None
        self._rest: Joints | None = None
        self._holds = 0  # so that a command notices a hold by another thread
        self.tasks = ArmTasks(self, "pa10", lambda: planner_for(settings), lambda: self._holds)

    def connect(self) -> RobotState:
        """Open the line and ask for the state."""
        planner_for(self.settings)  # the planner is created before the first command, because that is slow
        self._open()
        self.tasks.begin()
        state = self.state()
        self.tasks.look()
        return state

    def _open(self) -> None:
        """Connect, and tell the controller which boxes staff have added; it knows its own."""
        self.line.open()
        self._boot = None
        self.line.ask(Request("b"))
        for box in added_boxes(self.settings):
            corners = tuple(1000 * v for v in (*box.low, *box.high))
            self.line.ask(Request("b", corners, box.name.replace(" ", "_")))

    def close(self) -> None:
        """Close the line."""
        self.line.close()

    def state(self) -> RobotState:
        """Ask the controller for its state."""
        return self._take(self.line.state())

    def _take(self, arm: ArmState) -> RobotState:
        if self._boot is None:
            self._boot = arm.boot
        error = arm.mode == Mode.RANGE_ERROR
        pose = numbers(self._chain.forward(np.array(arm.q)))
        fault = f"Range error: {arm.note}." if error else ""
        if arm.boot != self._boot:
            fault = "The arm's control application was started again by its watchdog."
        moving = arm.moving or arm.mode == Mode.PROG_EXEC
        opening = arm.opening
        state = RobotState(
            self.clock.monotonic(), (*arm.q, opening), pose, moving, not fault, fault,
            (*arm.v, 0.0), (*arm.torque, 0.0), _words(arm),
        )  # fmt: skip
        return self.tasks.observe(self.keep(state))

    def execute(self, kind: str, args: dict[str, Any], permit: Permit, on_stage: OnStage) -> Outcome:
        """Run one command to its end."""
        check(kind, args, self.settings, self._latest)
        if kind == "noop":
            permit()
            return Outcome({}, self._latest)
        if kind in KINDS:
            return self.tasks.execute(kind, args, permit, on_stage)
        if kind.startswith("jog_"):
            request = self._velocity(kind, args)
            return self._jog(lambda _: request, permit, on_stage)
        if kind == "follow":
            follower = Follower(self._tool(self.state()), JOG_M_S, JOG_RAD_S)
            return self._jog(lambda free: self._towards(follower, self.steered(args), free), permit, on_stage)
        if kind == "gripper":
            return self._do(Request("g", (float(number(args, "closed") >= 0.5),)), args, permit, on_stage)
        if kind == "program":
            if "text" in args:
                self.line.teach(TAUGHT, args["text"])
            which = TAUGHT if "text" in args else number(args, "number")
            return self._do(Request("p", (which,)), args, permit, on_stage, len(steps_of(args)))
        outcome = self._do(request_of(kind, args), args, permit, on_stage)
        if kind == "ready":  # the arm is out of the cameras' way, and a turn begins here
            self.tasks.look()
        return outcome

    def _do(self, request: Request, args: dict[str, Any], permit: Permit, on_stage: OnStage, steps: int = 0) -> Outcome:
        """Run one request; `steps` is the number of steps of a program, 0 if only the controller knows."""

        def tell(arm: ArmState) -> None:
            if arm.program and arm.step:
                share = (arm.step - 1) / steps if steps else None
                on_stage(Progress(f"step {arm.step} of {steps}" if steps else f"step {arm.step}", share))

        free = until_held(permit, lambda: self._holds)
        before = self.line.state()
        if request.letter == STRAIGHT and self._take(before).moving:
            free()
            self._rests()
            before = self.line.state()
        self._take(before)
        began = self._say(request, CHECKED_S if request.letter == "p" else PLANNED_S, free, on_stage)
        if request.letter in MOTIONS:
            self._tell_path(request, before, began, on_stage)
        arm = self._until_rest(request, before, permit, tell)
        state = self._take(arm)
        if state.fault:
            raise HardwareFault(state.fault)
        if (request.letter in MOTIONS and arm.end == End.HELD) or (request.letter == "p" and arm.note):
            raise MotionHeld(" ".join(("The motion was stopped on its way.", *_sentence(arm.note))))
        self._rest = np.array(arm.q)
        return Outcome(dict(args), state)

    def _tell_path(self, request: Request, before: ArmState, began: float, on_stage: OnStage) -> None:
        """Report the path on which the arm moves since `began`, by the planner that the controller has too.

        An arm that moved already has gone on while the controller planned: it is asked where it is now.
        """
        if np.any(np.abs(before.v) > STILL_RAD_S):
            before, began = self.line.state(), self.clock.monotonic()
        q, v = np.array(before.q), np.array(before.v)
        v = v if np.any(np.abs(v) > STILL_RAD_S) else np.zeros_like(v)
        path = planner_for(self.settings).expected(motion_of(request), q, v)
        knots = None if path is None else knots_of(path)
        if knots is not None:
            on_stage(Moves(knots, began))

    def _say(self, request: Request, seconds: float, permit: Permit, on_stage: OnStage | None) -> float:
        """Send a motion; return when it was acknowledged (s of the clock).

        Its stage is reported after the line is free again, because a hold must not wait for the report.
        """
        said = False

        def last() -> None:
            nonlocal said
            permit()
            said = True

        try:
            self.line.ask(request, seconds, last)
        except ControllerRefused:
            permit()  # if another thread has held the arm, that is the reason
            raise
        finally:
            began = self.clock.monotonic()
            if said and on_stage is not None:
                on_stage("sent")
        if on_stage is not None:
            on_stage("acknowledged")
        return began

    def _until_rest(
        self, request: Request, before: ArmState, permit: Permit, tell: Callable[[ArmState], None]
    ) -> ArmState:
        limit = LONGEST_PROGRAM_S if request.letter == "p" else float(self._description["motion"]["limit_s"])
        allowed = Limit(self.clock, limit)
        while True:
            self.clock.sleep(POLL_S)
            arm = self.line.state()
            state = self._take(arm)
            tell(arm)
            if request.letter == "g":
                over = bool(state.fault) or self.line.ask(Request("w")) != "b"  # the state does not contain the fingers
            else:
                over = request.letter not in MOTIONS or (arm.motion > before.motion and arm.end != End.NONE)
            if state.fault or (over and not state.moving):
                return arm
            if request.letter in MOTIONS:
                permit()
            if allowed.over:
                self.hold()
                raise HardwareFault(f"The motion did not end within {limit:g} s and was held.")

    def _jog(self, velocity: Callable[[Permit], Request], permit: Permit, on_stage: OnStage) -> Outcome:
        """Send the velocity of each moment again and again while `permit` allows it.

        `velocity` gets a permit that a hold ends, too.
        """
        free = until_held(permit, lambda: self._holds)
        tell: OnStage | None = on_stage
        self._rest = None  # a reset after a jog must not return to its start
        try:
            while True:
                self._say(velocity(free), ANSWER_S, free, tell)
                tell = None
                state = self.state()
                if state.fault:
                    raise HardwareFault(state.fault)
                self.clock.sleep(JOG_S)
        finally:
            if self.line.is_open:
                self.line.hold()

    def _velocity(self, kind: str, args: dict[str, Any]) -> Request:
        if kind == "jog_joints":
            return joint_request("J", tuple(joint_velocity(self._chain, args)))
        return _twist(tool_velocity(args))

    def _towards(self, follower: Follower, hand: dict[str, Any], permit: Permit) -> Request:
        """Return the velocity from the newest state towards the hand; it may move the gripper. Raises HandLost."""
        assert self._latest is not None, "it was asked for before"
        twist = follower.twist(self._tool(self._latest), hand)
        if (closed := follower.grip(hand)) is not None:
            self._say(Request("g", (float(closed),)), ANSWER_S, permit, None)
        return _twist(twist)

    def _tool(self, state: RobotState) -> Matrix:
        """Return the tool's pose (4 x 4)."""
        return self._chain.forward(self._chain.joints_in(state.joints))

    def hold(self) -> RobotState:
        """Send `h` and wait until the set-point rests."""
        self._holds += 1
        return self._rests()

    def _rests(self) -> RobotState:
        self.line.hold()
        return until_at_rest(self.state, self.clock, REST_S, "The arm", LOOK_S)

    def recover(self, permit: Permit) -> RobotState:
        """Soft reset: connect again, leave a range error by the default position, return."""
        permit()
        back = self._rest
        if not self.line.is_open:
            self._open()
        self._boot = None
        arm = self.line.state()
        if arm.mode == Mode.RANGE_ERROR:
            self._home(permit)
        if back is not None:
            self._quietly(lambda: self._do(joint_request("j", tuple(back)), {}, permit, lambda _: None))
        return self.state()

    def _home(self, permit: Permit) -> None:
        request = joint_request("j", tuple(posture(self._description, "home")))
        limit = Limit(self.clock, SETTLED_S)
        while True:
            try:
                self._do(request, {}, permit, lambda _: None)
                return
            except OutOfWorkspace as error:
                raise HardwareFault(f"The way to the default position is blocked: {error}") from error
            except ControllerRefused as error:  # something still pushes the arm
                if limit.over:
                    raise HardwareFault(f"The arm does not come to rest: {error}") from error
                self.clock.sleep(POLL_S)

    @staticmethod
    def _quietly(go: Callable[[], Any]) -> None:
        """Return to the earlier position; if the way is blocked the arm stays, which is not a fault."""
        try:
            go()
        except OutOfWorkspace:
            return


def _twist(velocity: Joints) -> Request:
    """Return the request for a velocity of the tool (m/s along, rad/s about x y z)."""
    return Request("C", (*(velocity[:3] * 1000), *(degrees(v) for v in velocity[3:])))
