"""The wheels: every velocity passes here, after a permit, and a hold ends it for good."""

import contextlib
import random
from collections.abc import Callable
from dataclasses import replace
from math import hypot, remainder, tau

from robots.kit.clock import TIMER, Timer
from robots.kit.contract.errors import CameraFault, HardwareFault
from robots.kit.contract.session import Permit
from robots.kit.drivers.irat.brain.messages import Save, Seen
from robots.kit.drivers.irat.brain.process import SILENT, BrainProcess
from robots.kit.drivers.irat.line import IratLine
from robots.kit.drivers.irat.protocol import Velocity
from robots.kit.drivers.irat.senses import Senses
from robots.kit.drivers.irat.spec import Mode
from robots.kit.drivers.permits import until_held
from robots.kit.rovers.steering import Limits, Memory, Sensed, Steer, steer

STEP_S = 0.1
FRESH_S = 0.5  # older ranges or odometry: the wheels rest
BRAIN_AWAY_S = 60.0  # it may start again meanwhile
SILENT_S = 3.0  # of the robot
BLIND_S = 20.0  # without a usable picture
TROUBLED_S = 10.0  # of nothing but stalls and obstacles
DOCK_SEEN_S, FUNNEL_M, NEAREST_M = 1.0, 0.33, 0.05
STANDING_S, STANDING_M = 6.0, 0.05  # a robot that came no farther in this time backs off, or goes ahead, in turn
BATTERY_SILENT = "The robot does not tell how much charge its battery has."
FLAT = "The battery is almost flat and the dock was not reached; staff have to put the robot into its dock."
REST = Velocity(0.0, 0.0)


class Wheels:
    """Sends velocities for one command at a time; `holds` counts the holds of other threads."""

    def __init__(self, line: IratLine, brain: BrainProcess, senses: Senses, clock: Timer = TIMER) -> None:
        self.line, self.brain, self.senses, self.clock = line, brain, senses, clock
        self._sending = clock.lock()
        self.holds = 0
        self._dice = random.Random()
        self._begin()

    def seed(self, seed: int) -> None:
        """Seed the random numbers, so that they are the same each time."""
        self._dice.seed(seed)

    def _begin(self) -> None:
        self._memory, self._limits = Memory(), Limits()
        self._stepped_at, self._seeing_at = 0.0, self.clock.monotonic()
        self._brain_at = self._line_at = self.clock.monotonic()
        self._stood: tuple[float, float, float] | None = None  # where it stands, and since when
        self._way_out = 1
        self._dock, self._dock_at = 0.0, -1e9  # the distance of the dock's marker (m), and when it was seen

    def hold(self) -> None:
        """End the running command for good, and hold; return when the robot rests. Any thread.

        Raises LineGone, LineSilent, HardwareFault.
        """
        with self._sending:
            self.holds += 1
        self.line.hold()

    def drive(self, velocity: Velocity, permit: Permit) -> None:
        """Send a velocity for the next moment; `permit` is asked last. Raises what it raises, LineGone."""
        with self._sending:
            self.line.drive(velocity, permit)

    def during(self, permit: Permit, mode: Mode, act: Callable[[Permit], None]) -> None:
        """Run a motion with its permit; at its end the robot is held, whatever ended it.

        Once the battery is almost flat, the map is saved, too.
        """
        free = until_held(permit, lambda: self.holds)
        self._begin()
        self.senses.mode = mode
        try:
            act(free)
        finally:
            self.senses.mode, self.senses.find = Mode.RESTING, False
            try:
                if self.line.bridge.is_open:
                    self.line.hold()
            finally:
                if self.senses.critical:
                    with contextlib.suppress(HardwareFault):  # a brain that does not answer
                        self.brain.call(Save)

    def pause(self, permit: Permit) -> Seen | None:
        """Wait for the next moment; return the brain's newest answer.

        None: brain or robot is silent, and the wheels were commanded to rest. Raises HardwareFault if that lasts, or if
        the battery is almost flat or silent; CameraFault if no picture was of use for long.
        """
        self.clock.sleep(max(0.0, self._stepped_at + STEP_S - self.clock.monotonic()))
        now = self._stepped_at = self.clock.monotonic()
        self.senses.awake()
        if self.senses.critical:
            raise HardwareFault(FLAT)
        if self.senses.battery is None:
            raise HardwareFault(BATTERY_SILENT)
        seen = self.brain.fresh()
        hears = self.hears()
        if seen is not None:
            self._brain_at = now
            if seen.outer is not None:
                self._dock, self._dock_at = seen.outer.z, seen.at
            if seen.picture == "seen" or seen.picture == "full":
                self._seeing_at = now
            if now - self._seeing_at > BLIND_S:
                raise CameraFault(f"No picture of the robot's camera is of use: {seen.picture}.")
            if hears:
                return seen
        self.drive(REST, permit)
        self._memory = Memory()
        self._seeing_at = max(self._seeing_at, now - BLIND_S / 2)
        if now - self._brain_at > BRAIN_AWAY_S:
            raise HardwareFault(SILENT)
        return None

    def hears(self) -> bool:
        """Tell whether the robot was heard a moment ago; if not, the wheels are to rest.

        Raises HardwareFault once it is silent for long, LineBusy if another commands it.
        """
        self.line.obeys()
        now = self.clock.monotonic()
        if now - min(self.line.ranges.at, self.line.odometry.at) <= FRESH_S:
            self._line_at = now
        elif now - self._line_at > SILENT_S:
            raise HardwareFault("The robot's sensors are silent.")
        return self._line_at == now

    def steer(self, bearing: float | None, permit: Permit, mode: Mode) -> Steer:
        """Drive for a bearing (rad, left positive), or explore without one."""
        ranges, odometry = self.line.ranges.value, self.line.odometry.value
        assert ranges is not None and odometry is not None
        speed = odometry.velocity
        v, w = max(-10.0, min(speed.linear, 10.0)), max(-100.0, min(speed.angular, 100.0))
        ahead = None if bearing is None else remainder(bearing, tau)
        front = ranges.ahead if mode == Mode.DOCKING else min(ranges.ahead, self._before_dock)
        sensed = Sensed(ranges.left, front, ranges.right, v, w, ahead)
        self._standing(odometry.x, odometry.y)
        chosen, self._memory = steer(sensed, self._memory, STEP_S, self._dice.random(), self._limits)
        self.senses.mode = Mode.STUCK if self._memory.troubled_s > TROUBLED_S else mode
        self.drive(Velocity(chosen.v, chosen.w), permit)
        return chosen

    @property
    def _before_dock(self) -> float:
        """Return the room (m) before the dock's funnel, whose low guides no range sensor sees; else far."""
        near = self.clock.monotonic() - self._dock_at < DOCK_SEEN_S
        return max(self._dock - FUNNEL_M, NEAREST_M) if near else self._limits.far

    def _standing(self, x: float, y: float) -> None:
        """Let a robot that has not left its place for long back off or go ahead, in turn."""
        now = self.clock.monotonic()
        if self._stood is None or hypot(x - self._stood[0], y - self._stood[1]) > STANDING_M:
            self._stood = (x, y, now)
        elif now - self._stood[2] > STANDING_S:
            self._stood = (x, y, now)
            self._memory = replace(self._memory, reversing_s=self._way_out * self._limits.reverse_s, side=0)
            self._way_out = -self._way_out
