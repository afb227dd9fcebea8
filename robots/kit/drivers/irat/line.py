"""The owner's end of the iRat's wire: it claims, drives, holds, and stores the newest message of each topic."""

import threading
from collections.abc import Callable
from typing import Generic, TypeVar

from robots.kit.clock import TIMER, Timer, Until
from robots.kit.contract.errors import ControllerRestarted, HardwareFault, LineBusy, LineGone, LineSilent
from robots.kit.contract.session import Permit
from robots.kit.drivers.irat.messages import BatteryState, Odometry, Picture, Ranges, current_of
from robots.kit.drivers.irat.protocol import (
    BATTERY,
    CAMERA,
    CHARGER,
    CLAIM,
    DRIVE,
    HOLD,
    ODOMETRY,
    RANGES,
    REST_S,
    STATE,
    STATUS,
    TOPICS,
    Drive,
    Status,
    Velocity,
)
from robots.kit.drivers.rosbridge import Message
from robots.kit.drivers.rosbridge_client import ANSWER_S, Bridge, OpenConnection, connected

T = TypeVar("T")


class Newest(Generic[T]):
    """The newest value of a topic, and when it arrived (s, on its clock)."""

    def __init__(self, decode: Callable[[Message], T], clock: Timer = TIMER) -> None:
        self._decode, self._clock = decode, clock
        self._changed = threading.Condition()
        self.value: T | None = None
        self.at = 0.0

    def take(self, message: Message) -> None:
        """Keep a message's value. Raises Malformed; the older value stays then."""
        value = self._decode(message)
        with self._changed:
            self.value, self.at = value, self._clock.monotonic()
            self._changed.notify_all()

    def wait(self, seconds: float, after: float = 0.0) -> T:
        """Return the value, waiting for it at most so many seconds; `after`: only one that arrived later than that.

        Raises:
            LineSilent: none came.

        """
        with self._changed:
            heard = Until(self._changed, lambda: self.value is not None and self.at > after)
            if not self._clock.wait(heard, seconds):
                raise LineSilent("The robot is silent.")
            assert self.value is not None
            return self.value


class IratLine:
    """Thread safe. `picture` is called with each picture, in the connection's thread."""

    def __init__(
        self, address: str, epoch: int, picture: Callable[[Picture], None] | None = None, clock: Timer = TIMER,
        opened: OpenConnection = connected,
    ) -> None:  # fmt: skip
        self.bridge, self._epoch, self._picture = Bridge(address, clock, opened), epoch, picture
        self._clock, self._claimed_at = clock, 0.0
        self.odometry = Newest(Odometry.decode, clock)
        self.ranges = Newest(Ranges.decode, clock)
        self.battery = Newest(BatteryState.decode, clock)
        self.status = Newest(Status.decode, clock)
        self.charger = Newest(current_of, clock)

    def open(self) -> None:
        """Connect, claim the robot, and listen. Raises LineGone, LineSilent, LineBusy."""
        self.bridge.open()
        heard: tuple[tuple[str, Callable[[Message], None]], ...] = (
            (ODOMETRY, self.odometry.take), (RANGES, self.ranges.take), (BATTERY, self.battery.take),
            (STATE, self.status.take), (CHARGER, self.charger.take),
        )  # fmt: skip
        for topic, take in heard:
            self.bridge.subscribe(topic, TOPICS[topic], take)
        if self._picture is not None:
            self.watch(self._picture)
        self.claim()

    def claim(self) -> None:
        """Become the commander. Raises LineBusy if another epoch commands."""
        answer = self.bridge.call(CLAIM, {"epoch": self._epoch})
        if answer.get("success") is not True:
            self.bridge.close()
            raise LineBusy(f"The robot is used by another client: {answer.get('message')}.")
        self._claimed_at = self._clock.monotonic()

    def watch(self, picture: Callable[[Picture], None], every_s: float = 0.0) -> None:
        """Have the camera's pictures sent, at most one every `every_s`; the robot renders only what is watched."""
        self._picture = picture
        self.bridge.subscribe(CAMERA, TOPICS[CAMERA], lambda message: picture(Picture.decode(message)), every_s)

    def unwatch(self) -> None:
        """End the pictures."""
        self._picture = None
        self.bridge.unsubscribe(CAMERA)

    def close(self) -> None:
        """Close the connection; the robot holds."""
        self.bridge.close()

    def drive(self, velocity: Velocity, permit: Permit | None = None) -> None:
        """Send a velocity, which the robot forgets after 0.25 s; `permit` is called last. Raises LineGone, LineSilent.

        It carries the epoch, by which the robot knows its commander without knowing connections, and the stamp of the
        newest odometry, by which the robot refuses a velocity that a network has delayed for long.
        """
        if not self.bridge.is_open:
            raise LineGone("The robot's rosbridge is not connected.")
        heard = self.odometry.value or self.odometry.wait(ANSWER_S)
        self.bridge.publish(DRIVE, Drive(velocity, self._epoch, heard.stamp).encode(), permit)

    def obeys(self) -> None:
        """Return if this client commands the robot, by the robot's newest status.

        Raises LineBusy: another client does. ControllerRestarted: the robot has forgotten its commander, because behind
        a rosbridge_server it may start anew while the connection stays.
        """
        status = self.status.value
        if status is None or status.epoch == self._epoch:
            return
        if status.epoch > self._epoch:
            raise LineBusy(f"The robot is used by another client: epoch {status.epoch} commands it.")
        if self.status.at > self._claimed_at + ANSWER_S:  # by now no older status can arrive
            raise ControllerRestarted("The robot was started again and does not know its owner; connect again.")

    def ask(self) -> Status:
        """Ask for the robot's state now. Raises LineGone, LineSilent."""
        return Status.decode(self.bridge.call(STATUS))

    def hold(self) -> None:
        """Hold; return when the robot rests. Any thread, any time.

        Raises:
            LineGone, LineSilent: the connection.
            HardwareFault: it still moves after the longest time that a hold may take.

        """
        answer = self.bridge.call(HOLD, seconds=REST_S + ANSWER_S)
        if answer.get("success") is not True:
            raise HardwareFault(f"The robot did not come to rest: {answer.get('message')}.")

    @property
    def silent_s(self) -> float:
        """Return for how long nothing has been heard (s). Raises LineGone."""
        if not self.bridge.is_open:
            raise LineGone("The robot's rosbridge is not connected.")
        return self._clock.monotonic() - self.bridge.heard_at
