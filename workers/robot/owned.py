"""The robot of this process: its database row and its driver."""

import math
from collections.abc import Callable
from typing import Any

from robots import bus
from robots.grants import ROBOT
from robots.kit.clock import Clock
from robots.kit.contract.channels import finite, whole
from robots.kit.contract.errors import CameraFault
from robots.kit.contract.find import open_session
from robots.kit.contract.session import RobotState, Session
from robots.kit.packets import Changed
from robots.kit.vision.stability import Picture
from robots.models import Lease, Robot
from robots.prepared import Prepared
from robots.states import Cycle
from workers.authority.gate import KnownState
from workers.authority.lease import OwnerLease
from workers.door import GuardedSession
from workers.media.streams import Streams
from workers.robot.machine import OpenSession

_ROW: Prepared[Robot] = Prepared(lambda: Robot.objects.filter(pk=ROBOT))
FRESH_S = 1.0  # an older state does not say where the robot is now
PublishFrame = Callable[[str, bytes, str, Any], None]


def _blind(view: str) -> Picture:
    raise CameraFault("The robot has no camera.")


class OwnedRobot:
    """Row and driver of one robot; `running` is True from the owner's start to its end."""

    def __init__(
        self, robot: Robot, lease: OwnerLease, clock: Clock, trace: PublishFrame, streams: Streams,
        session: OpenSession = open_session,
    ) -> None:  # fmt: skip
        self.robot, self.clock = robot, clock
        self.running = False
        self._lease, self._trace, self._streams, self._session = lease, trace, streams, session
        self.now = lease.now  # the database's time
        self.time_left: Callable[[], float] = lambda: 0.0  # see `Session`; the gate's
        self.steered: Callable[[], dict[str, Any]] = dict  # see `Session`; the dead-man timer's
        self.look: Callable[..., Picture] = _blind  # see `Session`; the pictures'
        self._remembering, self._remembered = clock.lock(), -math.inf
        self.driver: Session = self._open_session()

    def renew_driver(self) -> None:
        """Create the driver again with the present epoch; some controllers need to know it."""
        self.driver = self._open_session()

    def _open_session(self) -> Session:
        robot, epoch = self.robot, self._lease.epoch
        self._streams.restart(epoch)

        def make() -> Session:
            made = self._session(robot.driver, robot.wire_address, robot.driver_settings(epoch), self._frame)
            made.on_packet, made.on_time_left = self._streams.take, lambda: self.time_left()
            made.on_steered, made.on_look = lambda: self.steered(), lambda *asked: self.look(*asked)
            return made

        return GuardedSession(make)

    def _frame(self, direction: str, data: bytes, words: str) -> None:
        self._trace(direction, data, words, getattr(self.driver, "line", None))

    def picture(self, view: str, seconds: float) -> bytes | None:
        """Return a picture that comes over the robot's own wire, None if there is none in so many seconds."""
        return self.driver.picture(view, seconds)

    def refresh(self) -> bool:
        """Read the row again. Return True if the change needs a new driver."""
        found = _ROW.first(robot=self.robot.pk)
        if found is None:
            raise Robot.DoesNotExist(self.robot.slug)
        old, self.robot = self.robot, found
        new = self.robot
        return (new.address, new.driver_settings()) != (old.address, old.driver_settings())

    def set_cycle(self, cycle: Cycle, reason: str, was: str) -> bool:
        """Advance the robot's turn cycle by a conditional UPDATE."""
        done = Robot.objects.filter(pk=self.robot.pk, cycle=was).update(cycle=cycle, reason=reason[:300])
        if done:
            self.robot.reason = reason[:300]  # else the same fault soon after would be taken for told
            bus.publish(self.robot.slug, Changed("robot"))
        return bool(done)

    def age(self, state: RobotState) -> float:
        """Return the age of a state (s)."""
        return self.since(state.at)

    def since(self, at: float) -> float:
        """Return how long ago (s) a driver's time was. Only here is the clock of drivers compared with the present."""
        return self.driver.clock.monotonic() - at

    def known_state(self) -> KnownState | None:
        """Return the values of a fresh state by name; None if there is none."""
        state = self.driver.latest()
        if state is None or self.age(state) > FRESH_S:
            return None
        spec = self.robot.spec()
        return KnownState(spec.named(state), *spec.speeds(state))

    def remember(self, state: RobotState) -> None:
        """Store the state in the lease row, by which needs are judged; one that is older than the last is dropped."""
        kept: dict[str, Any] = {"joints": whole(state.joints), "pose": whole(state.pose)}
        kept |= {"moving": state.moving, "ready": state.ready}
        if state.values:
            kept["values"] = finite(state.values)
        with self._remembering:  # threads that took a state one after another may come here the other way round
            if state.at >= self._remembered:
                self._remembered = state.at
                row = Lease.objects.filter(robot=self.robot, epoch=self._lease.epoch)
                row.update(state=kept, state_at=self.now())
