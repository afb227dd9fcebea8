"""What the owner tells those who watch: joints, live pictures, the trace of the wire."""

import logging
import time
from typing import TYPE_CHECKING

import redis

from robots import bus
from robots.drivers.contract import RobotState
from robots.drivers.errors import HardwareFault
from robots.messages import Trace, state_packet

if TYPE_CHECKING:
    from workers.runtime import Runtime

log = logging.getLogger(__name__)
STATE_HZ = 4  # where the description says nothing
TRACE_S = 0.25
ASK_S = 0.5
LEAST_S, LOOK_S = 0.01, 0.5


class Broadcast:
    """Two loops beside the control loop, and the driver's trace."""

    def __init__(self, runtime: "Runtime") -> None:
        self._runtime = runtime
        self._number = 0
        self._traced = False

    def states(self) -> None:
        """Publish the newest joints, some times a second; ask the hardware where it has been quiet."""
        runtime, asked, looked = self._runtime, 0.0, 0.0
        every = 1.0 / float(runtime.robot.description().get("motion", {}).get("state_hz", STATE_HZ))
        while runtime.running:
            time.sleep(every)
            if time.monotonic() - looked >= TRACE_S:
                looked = time.monotonic()
                self._traced = self._watched("trace")
            heard = runtime.driver.latest()
            quiet = heard is None or time.monotonic() - heard.at >= ASK_S
            if runtime.reach.connected and quiet and time.monotonic() - asked >= ASK_S:
                asked = time.monotonic()
                try:
                    runtime.driver.state()
                except HardwareFault as error:
                    runtime.reach.lost_while_idle(error)
            state = runtime.driver.latest()
            if state is not None:
                self._publish(state)

    def pictures(self, camera: int = 0) -> None:
        """Send a camera's live pictures while somebody watches it."""
        runtime, clock, sent = self._runtime, self._runtime.clock, self._runtime.clock.monotonic()
        while runtime.running:
            due = sent + runtime.brownout.every_s(runtime.pictures.every_s)
            clock.sleep(min(max(due - clock.monotonic(), LEAST_S), LOOK_S))
            now = clock.monotonic()
            if now < due:
                continue  # it may be time sooner than it was: the machine is less busy now
            sent = due if now - due < runtime.pictures.every_s else now
            runtime.pictures.live_once(runtime.driver.latest(), camera)

    def trace(self, way: str, data: bytes, words: str) -> None:
        """Publish one frame of the wire while a keeper looks."""
        if not self._traced:
            return
        runtime = self._runtime
        line = getattr(runtime.driver, "line", None)
        event = Trace(
            way, data.hex(" "), words, int(runtime.clock.now().timestamp() * 1000),
            getattr(line, "resent", 0), getattr(line, "broken", 0),
        )  # fmt: skip
        bus.publish_trace(runtime.robot.slug, event)

    def _watched(self, what: str) -> bool:
        try:
            return bus.watched(self._runtime.robot.slug, what)
        except (redis.RedisError, OSError):
            return False

    def _publish(self, state: RobotState) -> None:
        self._number += 1
        runtime = self._runtime
        at_ms = int((runtime.clock.now().timestamp() - (time.monotonic() - state.at)) * 1000)
        bus.publish_state(runtime.robot.slug, state_packet(self._number, at_ms, state, runtime.latch.latched))
