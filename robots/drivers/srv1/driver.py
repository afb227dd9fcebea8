"""The hall rover's driver: by hand, to a place, in place, and on patrol by its own rules."""

import contextlib
from collections.abc import Callable
from math import remainder, tau

from robots.contract.errors import (
    ControlsReleased,
    GaveUp,
    HardwareFault,
    RobotError,
)
from robots.contract.session import JSON, OnStage, Outcome, Permit, Progress, RobotState, Session, Trace
from robots.contract.values import check, number
from robots.description import load
from robots.drivers.srv1.answers import Status
from robots.drivers.srv1.following import TURNED_RAD, Pose, is_reached, toward, turning
from robots.drivers.srv1.line import RoverLine
from robots.drivers.srv1.modes import Mode
from robots.drivers.srv1.spec import SLICE_S
from robots.drivers.srv1.ways import Place, length, way
from robots.drivers.srv1.wheels import Wheels
from robots.drivers.tcp_stream import open_stream

REST_S = 2.0  # within which it rests after a hold
EARLY_S = 3.0  # a patrol ends by itself so long before its grant
BLOCKED_S = 10.0  # something stands in its way for so long: it gives up
MARGIN_M = 0.03  # before the reflex, where it counts as blocked
NEVER_BEGAN = "The rover did not move: what it was told came too late over its line."
IN_THE_WAY = "Something stands in the rover's way. It waited {:.0f} s."


class Driver(Session):
    """A `robots.contract.session.Session`. `settings` may hold `epoch`."""

    opened = staticmethod(open_stream)  # how a connection is opened

    def __init__(self, address: str, settings: JSON, trace: Trace | None = None) -> None:
        super().__init__(address, settings, trace)
        self._described = load("srv1")
        line = RoverLine(address, int(settings.get("epoch") or 1), trace, self.clock, self.opened)
        self.wheels = Wheels(line, self.keep, self.clock)

    def connect(self) -> RobotState:
        """Open the line and claim the rover."""
        return self.wheels.connect()

    def state(self) -> RobotState:
        """Ask the rover."""
        self.wheels.ask()
        state = self.latest()
        assert state is not None
        return state

    def execute(self, kind: str, args: JSON, permit: Permit, on_stage: OnStage) -> Outcome:
        """Run one command to its end."""
        check("srv1", kind, args, self.settings, self.latest())
        motions: dict[str, Callable[[], JSON]] = {
            "drive": lambda: self._drive(args, permit, on_stage),
            "go": lambda: self._go(args, permit, on_stage),
            "turn": lambda: self._turn(args, permit, on_stage),
            "patrol": lambda: self._patrol(permit, on_stage),
        }
        sent = motions[kind]()
        with contextlib.suppress(RobotError):  # it was done; whether the rover answers now is another matter
            return Outcome(sent, self.wheels.rest(REST_S))
        return Outcome(sent, self.latest())

    def _drive(self, args: JSON, permit: Permit, on_stage: OnStage) -> JSON:
        """Drive by hand while `permit` allows it. Raises GaveUp if the rover never began."""
        most = self._described["motion"]
        linear = number(args, "forward") * float(most["most_speed"])
        angular = number(args, "turn") * float(most["turn"]) / 2
        before, said = self.wheels.ask(), False

        def act(free: Permit) -> None:
            nonlocal said
            while True:
                status = self.wheels.ask()
                self.wheels.drive(linear, angular, status, free)
                said = _told(on_stage, said)
                self.wheels.pause()

        try:
            self.wheels.during(permit, Mode.HAND, act)
        except ControlsReleased:
            if said and (linear or angular) and self.wheels.ask().motion == before.motion:
                raise GaveUp(NEVER_BEGAN) from None
            raise
        return dict(args)

    def _go(self, args: JSON, permit: Permit, on_stage: OnStage) -> JSON:
        """Go to a place over the nodes of the map. Raises GaveUp where something stands in the way."""
        status, goal = self.wheels.ask(), (number(args, "x"), number(args, "y"))
        begin: Place = (status.x, status.y)
        corners = way(begin, goal)
        whole, said = max(length(begin, corners), 0.1), False

        def act(free: Permit) -> None:
            nonlocal said
            start = begin
            for number_, corner in enumerate(corners):
                last = number_ == len(corners) - 1
                while True:
                    status = self._unblocked(free)
                    pose = _pose(status)
                    if is_reached(pose, start, corner, passed=not last):
                        break
                    self.wheels.drive(*self._toward(status, start, corner), status, free)
                    said = _told(on_stage, said)
                    left = length((pose[0], pose[1]), corners[number_:])
                    on_stage(Progress(f"{left:.1f} m to go", min(max(1.0 - left / whole, 0.0), 1.0)))
                    self.wheels.pause()
                start = corner
            _told(on_stage, said)

        self.wheels.during(permit, Mode.GOING, act)
        return {"x": goal[0], "y": goal[1], "metres": round(whole, 2)}

    def _toward(self, status: Status, begin: Place, end: Place) -> tuple[float, float]:
        motion, stop = self._described["motion"], float(self._described["infrared"]["stop"])
        fastest, braking = float(motion["most_speed"]), float(motion["braking"])
        return toward(_pose(status), begin, end, fastest, status.infrared, stop, braking)

    def _unblocked(self, permit: Permit) -> Status:
        """Return the newest status once the way ahead is free. Raises GaveUp after a while."""
        near, began = float(self._described["infrared"]["stop"]) + MARGIN_M, self.clock.monotonic()
        while (status := self.wheels.ask()).infrared <= near:
            self.wheels.mode = Mode.WAITING
            permit()
            if self.clock.monotonic() - began > BLOCKED_S:
                raise GaveUp(IN_THE_WAY.format(BLOCKED_S))
            self.wheels.pause()
        self.wheels.mode = Mode.GOING
        return status

    def _turn(self, args: JSON, permit: Permit, on_stage: OnStage) -> JSON:
        """Turn in place by the odometry."""
        self.turn_by(number(args, "angle"), permit, on_stage)
        return dict(args)

    def turn_by(self, angle: float, permit: Permit, on_stage: OnStage) -> None:
        """Turn in place by so much (rad, to the left)."""
        last, left, said = self.wheels.ask(), angle, False

        def act(free: Permit) -> None:
            nonlocal last, left, said
            while abs(left) > TURNED_RAD:
                self.wheels.drive(0.0, turning(left), last, free)
                said = _told(on_stage, said)
                self.wheels.pause()
                status = self.wheels.ask()
                left -= _between(last.heading, status.heading)
                last = status
            _told(on_stage, said)

        self.wheels.during(permit, Mode.TURNING, act)

    def _patrol(self, permit: Permit, on_stage: OnStage) -> JSON:
        """Let the rover drive by its rules for a slice."""
        until, began, said = self.clock.monotonic() + SLICE_S - EARLY_S, self.wheels.where.driven, False

        def act(free: Permit) -> None:
            nonlocal said
            while self.clock.monotonic() < until:
                self.wheels.patrol(free)
                said = _told(on_stage, said)
                self.wheels.pause()
                self.wheels.ask()

        self.wheels.during(permit, Mode.PATROL, act)
        return {"driven": round(self.wheels.where.driven - began, 2)}

    def picture(self, view: str, seconds: float) -> bytes | None:
        """Return the next picture of the rover's camera, None where it has none or the line is lost."""
        try:
            return self.wheels.line.picture(seconds)
        except HardwareFault:
            return None

    def hold(self) -> RobotState:
        """Hold at once; return when the rover says that it rests."""
        self.wheels.holds += 1
        self.wheels.line.hold()
        return self.wheels.rest(REST_S)

    def close(self) -> None:
        """Close the connection; the rover rests."""
        self.wheels.line.close()


def _told(on_stage: OnStage, said: bool) -> bool:
    """Tell once that the rover has understood."""
    if not said:
        on_stage("sent")
        on_stage("acknowledged")
    return True


def _pose(status: Status) -> Pose:
    return status.x, status.y, status.heading


def _between(was: float, here: float) -> float:
    return remainder(here - was, tau)
