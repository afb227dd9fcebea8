"""What the owner tells those who watch: joints, live pictures, the trace of the wire."""

import logging
import time
from typing import TYPE_CHECKING

import redis

from robots import bus
from robots.drivers.contract import RobotState
from robots.drivers.errors import HardwareFault
from robots.messages import Trace, state_packet
from workers.pictures import LIVE_S

if TYPE_CHECKING:
    from workers.runtime import Runtime

log = logging.getLogger(__name__)
STATE_S = 0.25
ASK_S = 0.5


class Broadcast:
    """Two loops beside the control loop, and the driver's trace."""

    def __init__(self, runtime: "Runtime") -> None:
        self._runtime = runtime
        self._number = 0
        self._traced = False

    def states(self) -> None:
        """Publish the newest joints four times a second; ask the hardware where it has been quiet."""
        runtime, asked = self._runtime, 0.0
        while runtime.running:
            time.sleep(STATE_S)
            self._traced = self._watched("trace")
            heard = runtime.driver.latest()
            quiet = heard is None or time.monotonic() - heard.at >= ASK_S
            if runtime.connected and quiet and time.monotonic() - asked >= ASK_S:
                asked = time.monotonic()
                try:
                    runtime.driver.state()
                except HardwareFault as error:
                    runtime.lost_while_idle(error)
            state = runtime.driver.latest()
            if state is not None:
                self._publish(state)

    def pictures(self) -> None:
        """Send live pictures while somebody watches."""
        runtime = self._runtime
        while runtime.running:
            time.sleep(LIVE_S)
            runtime.pictures.live_once(runtime.driver.latest())

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
        bus.publish_state(
            runtime.robot.slug, state_packet(self._number, at_ms, state.joints, state.moving, runtime.latch.latched)
        )
