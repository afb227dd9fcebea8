"""The museum arm's driver: commands in SI units become lines of its controller's protocol."""

import time
from collections.abc import Callable
from functools import cache, lru_cache
from math import degrees
from typing import Any

import numpy as np

from robots.description import boxes, chain, load, posture
from robots.drivers.contract import (
    Argument,
    CommandKind,
    Features,
    OnStage,
    Outcome,
    Permit,
    Preview,
    RobotState,
    Trace,
)
from robots.drivers.errors import BadRequest, ControllerRefused, HardwareFault, Held, OutOfWorkspace
from robots.drivers.pa10.courses import LONGEST_PROGRAM_S, Courses
from robots.drivers.pa10.line import ANSWER_S, CHECKED_S, PLANNED_S, ArmLine
from robots.drivers.pa10.preview import preview, start
from robots.drivers.pa10.protocol import MOTIONS, ArmState, End, Malformed, Mode, Request
from robots.drivers.pa10.protocol import program as parse_program
from robots.drivers.pa10.units import joint_request, pose_request
from robots.drivers.permits import until_held
from robots.drivers.values import known, number, within
from robots.motion.chain import Joints
from robots.motion.planner import Refused
from robots.motion.pose import Six, matrix, numbers
from robots.motion.zones import Box

POLL_S = 0.05
REST_S = 2.0
SETTLED_S = 5.0  # the longest wait for an arm that was pushed
JOG_S = 0.08  # how often a velocity is said again; the controller forgets it after 0.25 s
JOG_SHARE = 0.3  # of full speed, so that it rests soon after the hand is gone
JOG_M_S, JOG_RAD_S = 0.15, 0.6
JOG_LONGEST_S = 20.0
GRIP_S = 3.0
LONGEST_TEXT = 6000
TAUGHT = 9000  # the number under which a program is handed over before it is executed
GRIPPER = "gripper"  # the last joint told: how far each finger is open, m
PLACES = ("pose", "line", "joints")  # commands that name one
PLACE = ("x", "y", "z", "roll", "pitch", "yaw")


@lru_cache(16)
def _courses(extra: tuple[Box, ...]) -> Courses:
    """Return what plans among the arm's own boxes and these; too slow to make for each command."""
    return Courses(extra)


@cache
def features(driver: str = "pa10") -> Features:
    """Return what the arm can do, from its description."""
    description, arm = load(driver), chain(driver)
    motion = description["motion"]
    limit = motion["limit_s"] + PLANNED_S
    slowest, fastest = motion["scale_range"]
    share = Argument("speed", "", slowest, fastest, required=False)
    joints = tuple(Argument(j.name, "rad", j.low, j.high) for j in arm.joints)
    place = (
        *(Argument(name, "m", -1.6, 1.6) for name in PLACE[:3]),
        *(Argument(name, "rad", -7.0, 7.0) for name in PLACE[3:]),
    )
    jog = tuple(Argument(name, "", -1.0, 1.0, required=False) for name in arm.names)
    hand = tuple(Argument(name, "", -1.0, 1.0, required=False) for name in PLACE)
    return Features(
        name=description["name"],
        joints=(*arm.names, GRIPPER),
        handover=("ready",),
        commands=(
            CommandKind("joints", "Move joints", (*joints, share), limit_s=limit, replaceable=True),
            CommandKind("pose", "Move hand", (*place, share), limit_s=limit, replaceable=True),
            CommandKind("line", "Move hand straight", (*place, share), limit_s=limit, replaceable=True),
            CommandKind("gripper", "Gripper", (Argument("closed", "", 0.0, 1.0),), limit_s=10.0),
            CommandKind(
                "program",
                "Program",
                (
                    Argument("number", "", 1.0, 9999.0, required=False),
                    Argument("text", "", 1, LONGEST_TEXT, required=False, text=True),
                ),
                limit_s=LONGEST_PROGRAM_S,
            ),
            CommandKind("jog_joints", "Jog joints", jog, limit_s=JOG_LONGEST_S, held=True),
            CommandKind("jog_hand", "Jog hand", hand, limit_s=JOG_LONGEST_S, held=True),
            CommandKind("ready", "Ready position", limit_s=limit, replaceable=True),
            CommandKind("home", "Default position", limit_s=limit, replaceable=True),
            CommandKind("noop", "No operation", limit_s=5.0, moves=False, still=False),
        ),
    )


def _words(arm: ArmState) -> str:
    """Return the controller's register as the paper writes it, and the step of a program that runs."""
    register = arm.mode.replace("_", " ")
    return f"{register}: program {arm.program}, step {arm.step}" if arm.program else register


class Driver:
    """See `robots.drivers.contract.Driver`. `settings` may hold `epoch`, `token` and more forbidden `boxes`."""

    def __init__(self, address: str, settings: dict[str, Any], trace: Trace | None = None) -> None:
        self._description = load("pa10")
        self._extra = boxes({"box": settings.get("boxes", ())})
        self._chain, self._courses = chain("pa10"), _courses(self._extra)
        self._planner = self._courses.planner
        self.line = ArmLine(address, int(settings.get("epoch", 0)), str(settings.get("token", "")), trace)
        self._latest: RobotState | None = None
        self._boot: int | None = None
        self._rest: Joints | None = None
        self._holds = 0  # so that a command knows of a hold by another thread
        self.features = features()

    def connect(self) -> RobotState:
        """Open the line and ask."""
        self._open()
        return self.state()

    def _open(self) -> None:
        """Connect, and tell the controller of the keepers' boxes; its own it knows."""
        self.line.open()
        self._boot = None
        self.line.ask(Request("b"))
        for box in self._extra:
            corners = tuple(1000 * v for v in (*box.low, *box.high))
            self.line.ask(Request("b", corners, box.name.replace(" ", "_")))

    def close(self) -> None:
        """Close the line."""
        self.line.close()

    def latest(self) -> RobotState | None:
        """Return the newest state heard."""
        return self._latest

    def state(self) -> RobotState:
        """Ask the controller."""
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
        self._latest = RobotState(
            time.monotonic(), (*arm.q, opening), pose, moving, not fault, fault,
            (*arm.v, 0.0), (*arm.torque, 0.0), _words(arm),
        )  # fmt: skip
        return self._latest

    def check(self, kind: str, args: dict[str, Any], pose: tuple[float, ...] | None = None) -> None:
        """Refuse unknown kinds, bad values, and targets outside limits, reach or in a box."""
        self._bounded(kind, args)
        if kind == "program":
            self._steps(args)
        if kind in PLACES:
            try:
                self._planner.stand(self._target(kind, args))
            except Refused as error:
                raise OutOfWorkspace(f"The arm cannot go there: {error}.") from error

    def _bounded(self, kind: str, args: dict[str, Any]) -> None:
        """Refuse unknown kinds and values that are none, or outside their range; the planner names joints' limits."""
        spec = known(self.features, kind, args)
        within(spec, {k: v for k, v in args.items() if k == "speed" or kind != "joints"})

    def preview(self, kind: str, args: dict[str, Any], joints: tuple[float, ...]) -> Preview:
        """See `robots.drivers.contract.Previews`."""
        self._bounded(kind, args)
        here = start(joints, posture(self._description, "ready"))
        if kind == "program":
            return preview(self._courses, self._steps(args), here, numbered=True)
        if kind not in PLACES and f"{kind}_deg" not in self._description["arm"]:
            raise BadRequest(f"There is no way to show for the command {kind}: it leads to no place.")
        return preview(self._courses, [self._request(kind, args)], here, numbered=False)

    def _steps(self, args: dict[str, Any]) -> list[Request]:
        """Return the steps of the program given as text; none for one that the controller has. Raises BadRequest."""
        if ("text" in args) == ("number" in args):
            raise BadRequest("A program is given by its number or as a text.")
        if "number" in args:
            return []
        try:
            steps = parse_program(args["text"])
        except Malformed as error:
            raise BadRequest(f"The program makes no sense: {error}.") from error
        if not steps:
            raise BadRequest("The program has no step.")
        return steps

    def _target(self, kind: str, args: dict[str, Any]) -> Joints:
        if kind == "joints":
            return np.array([number(args, name) for name in self._chain.names])
        near = np.array(self._latest.joints[:-1]) if self._latest else posture(self._description, "ready")
        return self._planner.reach(matrix(self._six(args)), near)

    @staticmethod
    def _six(args: dict[str, Any]) -> Six:
        x, y, z, roll, pitch, yaw = (number(args, name) for name in PLACE)
        return x, y, z, roll, pitch, yaw

    def execute(self, kind: str, args: dict[str, Any], permit: Permit, on_stage: OnStage) -> Outcome:
        """Do one command and wait for its end."""
        self.check(kind, args)
        if kind == "noop":
            permit()
            return Outcome({}, self._latest)
        if kind.startswith("jog_"):
            return self._jog(kind, args, permit, on_stage)
        if kind == "gripper":
            return self._do(Request("g", (float(number(args, "closed") >= 0.5),)), args, permit, on_stage)
        if kind == "program":
            if "text" in args:
                self.line.teach(TAUGHT, args["text"])
            which = TAUGHT if "text" in args else number(args, "number")
            return self._do(Request("p", (which,)), args, permit, on_stage)
        return self._do(self._request(kind, args), args, permit, on_stage)

    def _request(self, kind: str, args: dict[str, Any]) -> Request:
        scale = number(args, "speed") if "speed" in args else None
        if kind in ("pose", "line"):
            return pose_request("k" if kind == "pose" else "l", self._six(args), scale)
        if kind == "joints":
            return joint_request("j", tuple(number(args, name) for name in self._chain.names), scale)
        return joint_request("j", tuple(posture(self._description, kind)), scale)

    def _do(self, request: Request, args: dict[str, Any], permit: Permit, on_stage: OnStage) -> Outcome:
        free = until_held(permit, lambda: self._holds)
        before = self.line.state()
        self._take(before)
        self._say(request, CHECKED_S if request.letter == "p" else PLANNED_S, free, on_stage)
        arm = self._until_rest(request, before, permit)
        state = self._take(arm)
        if state.fault:
            raise HardwareFault(state.fault)
        if (request.letter in MOTIONS and arm.end == End.HELD) or (request.letter == "p" and arm.note):
            raise Held(f"The motion was stopped on its way.{f' {arm.note}.' if arm.note else ''}")
        self._rest = np.array(arm.q)
        return Outcome(dict(args), state)

    def _say(self, request: Request, seconds: float, permit: Permit, on_stage: OnStage | None) -> None:
        """Ask for a motion. It is told of when the line is free again, for a hold must not wait for the telling."""
        said = False

        def last() -> None:
            nonlocal said
            permit()
            said = True

        try:
            self.line.ask(request, seconds, last)
        except ControllerRefused:
            permit()  # another thread has held the arm meanwhile: that is the reason then
            raise
        finally:
            if said and on_stage is not None:
                on_stage("sent")
        if on_stage is not None:
            on_stage("acknowledged")

    def _until_rest(self, request: Request, before: ArmState, permit: Permit) -> ArmState:
        limit = LONGEST_PROGRAM_S if request.letter == "p" else float(self._description["motion"]["limit_s"])
        until = time.monotonic() + limit
        while True:
            time.sleep(POLL_S)
            arm = self.line.state()
            state = self._take(arm)
            if request.letter == "g":
                over = bool(state.fault) or self.line.ask(Request("w")) != "b"  # fingers are no part of the state
            else:
                over = request.letter not in MOTIONS or (arm.motion > before.motion and arm.end != End.NONE)
            if state.fault or (over and not state.moving):
                return arm
            if request.letter in MOTIONS:
                permit()
            if time.monotonic() > until:
                self.hold()
                raise HardwareFault(f"The motion did not end within {limit:g} s and was held.")

    def _jog(self, kind: str, args: dict[str, Any], permit: Permit, on_stage: OnStage) -> Outcome:
        """Say the velocity again and again for as long as `permit` lets it."""
        request = self._velocity(kind, args)
        free = until_held(permit, lambda: self._holds)
        tell: OnStage | None = on_stage
        self._rest = None  # a reset after a jog must not lead back to where it began
        try:
            while True:
                self._say(request, ANSWER_S, free, tell)
                tell = None
                state = self.state()
                if state.fault:
                    raise HardwareFault(state.fault)
                time.sleep(JOG_S)
        finally:
            if self.line.is_open:
                self.line.hold()

    def _velocity(self, kind: str, args: dict[str, Any]) -> Request:
        if kind == "jog_joints":
            share = np.array([number({name: 0.0} | args, name) for name in self._chain.names])
            return joint_request("J", tuple(share * self._chain.velocity * JOG_SHARE))
        share = np.array([number({name: 0.0} | args, name) for name in PLACE])
        return Request("C", (*(share[:3] * JOG_M_S * 1000), *(degrees(v) for v in share[3:] * JOG_RAD_S)))

    def hold(self) -> RobotState:
        """Send `h` and wait until the set-point rests."""
        self._holds += 1
        self.line.hold()
        until = time.monotonic() + REST_S
        while True:
            state = self.state()
            if not state.moving:
                return state
            if time.monotonic() > until:
                raise HardwareFault("The arm did not come to rest after a hold.")
            time.sleep(0.01)

    def recover(self, permit: Permit) -> RobotState:
        """Soft reset: connect again, leave a range error by the default position, go back."""
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
        until = time.monotonic() + SETTLED_S
        while True:
            try:
                self._do(request, {}, permit, lambda _: None)
                return
            except OutOfWorkspace as error:
                raise HardwareFault(f"The way to the default position is blocked: {error}") from error
            except ControllerRefused as error:  # something still pushes the arm about
                if time.monotonic() > until:
                    raise HardwareFault(f"The arm does not come to rest: {error}") from error
                time.sleep(POLL_S)

    @staticmethod
    def _quietly(go: Callable[[], Any]) -> None:
        """Go where the arm was before; where the way is barred it stays, which is no fault."""
        try:
            go()
        except OutOfWorkspace:
            return
