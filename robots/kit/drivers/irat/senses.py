"""Collects the robot's messages: feeds the brain with odometry and pictures, and makes the robot's state."""

import contextlib
import threading
from collections.abc import Callable
from math import cos, hypot, remainder, sin, tau

from robots.kit.clock import TIMER, Timer, Until
from robots.kit.contract.errors import RobotError
from robots.kit.contract.session import RobotState
from robots.kit.description import load
from robots.kit.drivers.irat.brain.messages import Feed
from robots.kit.drivers.irat.brain.process import BrainProcess
from robots.kit.drivers.irat.line import IratLine
from robots.kit.drivers.irat.messages import BatteryState, Odometry, Picture
from robots.kit.drivers.irat.protocol import FULL
from robots.kit.drivers.irat.spec import Mode

STEP_S, REST_S = 0.1, 1.0  # between two steps: on the way, and at rest
LONGEST_STEP_S = 1.0
LEAST_S, LATE_S = 0.02, 0.05  # the shortest pause; how late a picture may be before a step is sent without it
FRESH_S = 0.5
CHARGER_FRESH_S = 2.0
BATTERY_FRESH_S = 10.0
AWAKE_S = 3.0  # for so long after a motion, or after somebody wanted a picture, the robot's camera runs
FASTEST_M_S, FASTEST_RAD_S = 0.4, 5.0
JUMP_M = 0.4  # odometry that changes by more in a step has begun anew


class Senses:
    """Feeds the brain in a thread of its own, from `start` to `close`. `keep` gets each new state."""

    def __init__(
        self, line: IratLine, brain: BrainProcess, keep: Callable[[RobotState], object], clock: Timer = TIMER
    ) -> None:
        self._line, self._brain, self._keep, self._clock = line, brain, keep, clock
        self._battery = load("irat")["battery"]
        self._changed = threading.Condition()
        self._picture: Picture | None = None
        self._fed: Picture | None = None  # the newest picture that the brain got
        self._picture_at = self._awake_until = self._watch_every = 0.0
        self._watching = self._running = False
        self._thread: threading.Thread | None = None
        self._here: Odometry | None = None
        self._stepped_at = 0.0
        self.driven = 0.0  # m, by odometry
        self.mode = Mode.RESTING
        self.find = False  # whether the dock's markers are searched for
        self.fault = ""

    def start(self) -> None:
        """Begin to feed the brain."""
        self.close()
        self._running, self._here, self._watching = True, None, False
        self._thread = self._clock.spawn(self._loop, "irat-senses")

    def close(self) -> None:
        """End the thread."""
        self._running = False
        if self._thread is not None and self._thread is not threading.current_thread():
            self._thread.join(2.0)

    def awake(self) -> None:
        """Keep the camera running for the next seconds."""
        self._awake_until = self._clock.monotonic() + AWAKE_S

    def take(self, picture: Picture) -> None:
        """Keep the newest picture; called in the connection's thread."""
        with self._changed:
            self._picture, self._picture_at = picture, self._clock.monotonic()
            self._changed.notify_all()

    def picture(self, seconds: float) -> bytes | None:
        """Return the first JPEG that arrives from now on, None if none does in so many seconds."""
        since = self._clock.monotonic()
        self.awake()
        with self._changed:
            self._clock.wait(Until(self._changed, lambda: self._picture_at > since), seconds)
            return self._picture.jpeg if self._picture is not None and self._picture_at > since else None

    def _loop(self) -> None:
        """Step ten times a second while the robot moves or somebody watches, otherwise once a second."""
        fed = 0.0
        while self._running:
            awake = self.is_awake
            self._clock.sleep(LEAST_S)
            self._await_picture(STEP_S + LATE_S if awake and self._watching else REST_S / 4)
            if not self._running or not self._line.bridge.is_open:
                continue
            with contextlib.suppress(RobotError):  # the connection has just ended
                self._watch(awake)
            self._keep(self.state())
            if awake or self._clock.monotonic() - fed >= REST_S:
                fed = self._clock.monotonic()
                self.step(fed)

    @property
    def is_awake(self) -> bool:
        """Tell whether the robot moves or somebody watches, so that it steps ten times a second."""
        return self._clock.monotonic() < self._awake_until or self._moving

    def _await_picture(self, seconds: float) -> None:
        """Wait for a picture that was not fed yet, at most so many seconds."""
        with self._changed:
            self._clock.wait(Until(self._changed, lambda: self._picture is not self._fed), seconds)

    @property
    def _moving(self) -> bool:
        status = self._line.status.value
        return status is not None and status.moving

    def _watch(self, awake: bool) -> None:
        """Have pictures sent only while they are needed."""
        if awake == self._watching:
            return
        if awake:
            self._line.watch(self.take, STEP_S)
        else:
            self._line.unwatch()
        self._watching = awake

    def step(self, now: float) -> None:
        """Feed the brain with the way since the last step, and with the picture if there is a new one."""
        here, at = self._line.odometry.value, self._line.odometry.at
        if here is None or now - at > FRESH_S:
            self._here = None
            return
        was, dt = self._here, min(now - self._stepped_at, LONGEST_STEP_S)
        distance, turn = between(was, here) if was is not None else (0.0, 0.0)
        if abs(distance) > JUMP_M:
            distance = turn = 0.0
        # messages may come late and together: the whole way counts, at no more than the robot's greatest speed
        dt = min(max(dt, abs(distance) / FASTEST_M_S, abs(turn) / FASTEST_RAD_S), LONGEST_STEP_S)
        with self._changed:
            picture = self._picture
        jpeg = picture.jpeg if picture is not None and picture is not self._fed else None
        speeds = (distance / dt, turn / dt) if dt else (0.0, 0.0)
        if self._brain.feed(Feed(now, *speeds, dt, jpeg, self.find, self.charging)):
            self._here, self._stepped_at, self._fed = here, now, picture
            self.driven += abs(distance)

    @property
    def seeing(self) -> bool:
        """Tell whether the newest step had a picture; this keeps the camera running."""
        self.awake()
        return self._brain.newest is not None and self._brain.newest.picture != "none"

    @property
    def charging(self) -> bool:
        """Tell whether current flows from the charger; nothing else counts."""
        charger = self._line.charger
        flows = (charger.value or 0.0) > 0.0 and self._clock.monotonic() - charger.at < CHARGER_FRESH_S
        return flows and self.battery is not None

    @property
    def battery(self) -> BatteryState | None:
        """Return what the battery told last; None if it has been silent for long."""
        battery = self._line.battery
        return battery.value if self._clock.monotonic() - battery.at < BATTERY_FRESH_S else None

    @property
    def full(self) -> bool:
        """Tell whether the charger says that the battery is full."""
        battery = self.battery
        return battery is not None and battery.status == FULL

    @property
    def share(self) -> float:
        """Return the share of the battery's charge that is left; 1 where it is not known."""
        battery = self.battery
        return battery.share if battery is not None else 1.0

    @property
    def low(self) -> bool:
        """Tell whether it is time to charge."""
        return self.share < float(self._battery["low"])

    @property
    def critical(self) -> bool:
        """Tell whether so little is left that the robot must rest and wait for staff."""
        return self.share < float(self._battery["critical"]) and not self.charging

    def state(self) -> RobotState:
        """Return the newest state, as it was heard."""
        line, seen, battery = self._line, self._brain.newest, self.battery
        status, values = line.status.value, {"driven": self.driven, "charging": float(self.charging)}
        if battery is not None:
            values |= {"battery": battery.voltage, "charge": 100.0 * battery.share}
        if seen is not None:
            values |= {"map": seen.map_number, "experiences": seen.experiences, "docks": seen.docks}
        resting = Mode.CHARGING if self.charging else Mode.FLAT if self.critical else Mode.RESTING
        return RobotState(
            line.status.at, (), seen.pose if seen is not None else (), self._moving,
            status is not None and seen is not None and not self.fault, self.fault, twist=self._twist(),
            mode=resting if self.mode == Mode.RESTING else self.mode, values=values,
        )  # fmt: skip

    def _twist(self) -> tuple[float, ...]:
        """Return the newest velocity by the wheels' odometry: forward (m/s), to the left, turning left (rad/s)."""
        odometry = self._line.odometry.value
        return () if odometry is None else (odometry.velocity.linear, 0.0, odometry.velocity.angular)


def between(was: Odometry, here: Odometry) -> tuple[float, float]:
    """Return how far the robot came (m, forward) and how much it turned (rad) from one odometry to the next."""
    turn = remainder(here.heading - was.heading, tau)
    along = was.heading + turn / 2
    dx, dy = here.x - was.x, here.y - was.y
    ahead = dx * cos(along) + dy * sin(along)
    half = turn / 2
    arc = half / sin(half) if abs(half) > 1e-6 else 1.0
    return (ahead * arc if abs(ahead) > 1e-9 or hypot(dx, dy) < 1e-9 else 0.0), turn
