"""The wheels: every velocity passes here, after a permit, and a hold ends it for good."""

import contextlib
from collections.abc import Callable
from math import degrees
from pathlib import Path

from robots.kit.clock import TIMER, Timer
from robots.kit.contract.errors import ControllerRestarted, HardwareFault, LineGone, LineSilent
from robots.kit.contract.session import Permit, RobotState
from robots.kit.drivers.srv1 import extension
from robots.kit.drivers.srv1.alone import Alone
from robots.kit.drivers.srv1.answers import Status
from robots.kit.drivers.srv1.line import RoverLine
from robots.kit.drivers.srv1.refusals import NotNow
from robots.kit.drivers.srv1.rules import channel_value
from robots.kit.drivers.srv1.spec import Mode
from robots.kit.drivers.srv1.unseen import Unseen
from robots.kit.drivers.srv1.whereabouts import Whereabouts

STEP_S = 0.1
REST_S = 2.0  # within which it rests after a hold
LOST_S = 0.25  # without an answer for so long, or twice as long as an answer takes, a velocity is lost
SLOW_S = 0.05  # where answers take longer, no extra status is requested: that of the last velocity is new enough
LEAST_PAUSE_S = 0.01  # in which others may use the line
RESTARTED = "The rover was started again and does not know its owner; connect again."
OUT_OF_REACH = "The rover was out of reach for so long that it has come to rest by itself."
WORDS = {"rest": Mode.RESTING, "hand": Mode.HAND, "patrol": Mode.PATROL}


def compass_deg(status: Status) -> float:
    """Return where the rover looks, clockwise from north, which is the hall's y axis (degrees, 0 to 360)."""
    return (90.0 - degrees(status.heading)) % 360.0


class Wheels:
    """Sends velocities for one command at a time, and makes states. `keep` gets each new state."""

    def __init__(
        self, line: RoverLine, alone: Alone, unseen: Unseen, keep: Callable[[RobotState], RobotState],
        clock: Timer = TIMER, file: Path | None = None,
    ) -> None:  # fmt: skip
        self.line, self.alone, self._unseen, self._keep, self.clock = line, alone, unseen, keep, clock
        self.where = Whereabouts(file)
        self.mode = Mode.RESTING
        self._boot: int | None = None
        self.holds = 0  # of other threads
        self._closed = True  # by its owner: nothing is opened again by itself
        self.status: Status | None = None  # the newest
        self._told: Status | None = None  # the answer to the last velocity, until it is used
        self.newest = RobotState(0.0, (), (), False, False)

    def connect(self) -> RobotState:
        """Open the line and ask the rover. Raises LineGone, LineSilent, LineBusy."""
        self._closed = False
        status = self.line.open()
        self._boot = status.boot
        state = self.take(status)
        self._catch_up()
        return state

    def _catch_up(self) -> None:
        """Read what the rover did while it was not connected."""
        where = self.where
        self._unseen.catch_up((lambda status: where.pose(status)[:2]) if where.is_known else None)

    def close(self) -> None:
        """Close the line; a rover that may drive by itself is held before, where it can be reached."""
        self._closed = True
        if self.alone.rests_within:
            with contextlib.suppress(LineGone):
                self.line.hold()
        self.line.close()

    def ask(self) -> Status:
        """Ask the rover, and keep its state. Raises LineGone, LineSilent, ControllerRestarted."""
        status = self.line.status()
        self.take(status)
        return self._same(status)

    def next_status(self) -> Status:
        """Return the status to which the next velocity of a motion answers; only for the thread that moves the rover.

        On a slow line it is the answer to the last velocity; otherwise, and if that was lost, the same as `ask`.
        """
        status, self._told = self._told, None
        return self.ask() if status is None else self._same(status)

    def _same(self, status: Status) -> Status:
        """Return the status of the rover that was claimed. Raises ControllerRestarted."""
        if status.boot != self._boot or status.epoch != self.line.epoch:
            raise ControllerRestarted(RESTARTED)
        return status

    def take(self, status: Status) -> RobotState:
        """Keep what a status says, as a state."""
        self.where.take(status)
        self._unseen.take_status(status)
        self.status = status
        said = WORDS[status.mode]
        restarted = status.boot != self._boot
        self.newest = self._keep(
            RobotState(
                self.clock.monotonic(), (), self.where.pose(status) if self.where.is_known else (), status.moving,
                not restarted,
                "The rover was started again." if restarted else "",
                mode=self.mode if self.mode is not Mode.RESTING else said,
                twist=(status.linear, 0.0, status.angular),
                values={
                    "infrared": status.infrared, "sonar": status.sonar, "spread": self.where.spread,
                    "driven": self.where.driven, "battery": status.volts, "temperature": status.temperature,
                    "humidity": 100 * status.humidity, "light": 100 * status.light,
                    "presence": float(status.presence), "rules": float(channel_value(status.rules)),
                    "compass": compass_deg(status),
                },
            )
        )  # fmt: skip
        return self.newest

    def during(self, permit: Permit, mode: Mode, act: Callable[[Permit], None]) -> None:
        """Run a motion with its permit; at its end the rover is held, and rests, whatever ended it."""
        self.mode, self._told = mode, None
        try:
            act(permit)
        finally:
            self.mode, self._told = Mode.RESTING, None
            if self.alone.rests_within:
                self._settle()
            elif self.line.is_open:
                self.line.hold()
                with contextlib.suppress(HardwareFault):  # what ended it tells more
                    self.rest(REST_S)
            if self.status is not None:
                self.where.keep(self.status)

    def _settle(self) -> None:
        """Hold until the rover says that it rests, or its permit is certainly over: no command has ended before."""
        while self.alone.rests_within and not self._closed:
            with contextlib.suppress(HardwareFault):
                if not self.line.is_open:
                    self.take(self.line.open())
                self.line.hold()
                self.rest(STEP_S)
                self._catch_up()
            self.pause()

    def find_again(self, permit: Permit) -> None:
        """Connect again, for as long as the rover drives on by its permit.

        Raises LineGone after that, ControllerRestarted, and what `permit` raises.
        """
        while self.alone.remaining_s and not self._closed:
            permit()
            with contextlib.suppress(LineGone, LineSilent):
                status = self.line.open()
                self.take(status)
                if status.boot != self._boot:
                    raise ControllerRestarted(RESTARTED)
                self._catch_up()
                return
            self.pause()
        raise LineGone(OUT_OF_REACH)

    def drive(self, linear: float, angular: float, status: Status, permit: Permit) -> None:
        """Send a velocity (m/s, rad/s) that answers to this status; one that comes too late does nothing.

        Raises what else `RoverLine.ask` raises.
        """
        self._say(extension.Velocity(self.line.epoch, linear, angular, status.uptime_ms), permit)

    def patrol(self, status: Status, permit: Permit, aside: float) -> None:
        """Let the rover drive by its rules until the next message, and by its permit for a while without one.

        `aside`: the direction of its way, to the left of its heading (rad).

        Raises what else `RoverLine.ask` raises.
        """
        with contextlib.suppress(NotNow, LineSilent):
            self.alone.renew(status, self.where.pose(status), self.where.spread, permit)
        self._say(extension.Patrol(self.line.epoch, status.uptime_ms, aside), permit)

    def _say(self, command: extension.Command, permit: Permit) -> None:
        """Send a command that the rover forgets soon. A lost one is never resent; the next answers to a new status."""
        with contextlib.suppress(NotNow, LineSilent):  # a rover that is silent does not answer the next question either
            answer = self.line.ask(command, max(LOST_S, 2 * self.line.answer_s), permit)
            if isinstance(answer, Status) and self.line.answer_s > SLOW_S:
                self._told = answer
                self.take(answer)

    def pause(self) -> None:
        """Wait for the next step; on a slow line the answer to a velocity has taken a part of that time, or all."""
        spent = self.line.answer_s if self._told is not None else 0.0
        self.clock.sleep(max(STEP_S - spent, LEAST_PAUSE_S))

    def rest(self, seconds: float) -> RobotState:
        """Ask until the rover rests, or has rested and begun its next motion, which is another command's.

        Raises HardwareFault where it does neither in so many seconds.
        """
        until, motion = self.clock.monotonic() + seconds, None
        while True:
            status = self.line.status()
            state = self.take(status)
            motion = status.motion if motion is None else motion
            if not status.permit_ms and (not state.moving or status.motion != motion):
                self.alone.note_end()
                return state
            if self.clock.monotonic() > until:
                raise HardwareFault("The rover did not come to rest after a hold.")
            self.line.hold()  # the one before may have been lost on the way
            self.clock.sleep(STEP_S / 2)
