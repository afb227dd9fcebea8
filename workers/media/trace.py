"""The wire trace: every frame sent and received, published while staff watch."""

from typing import Any

import redis

from robots import bus
from robots.kit.clock import Clock
from robots.kit.packets import Trace


class WireTrace:
    """Publishes the frames of one robot's line while `watched`."""

    def __init__(self, slug: str, clock: Clock) -> None:
        self._slug, self._clock = slug, clock
        self._watched = False

    def look(self) -> None:
        """Ask Redis whether somebody watches the trace."""
        try:
            self._watched = bus.watched(self._slug, "trace")
        except (redis.RedisError, OSError):
            self._watched = False

    def publish(self, direction: str, data: bytes, words: str, line: Any) -> None:
        """Publish one frame. `line` counts resent and broken frames, or is None."""
        if not self._watched:
            return
        at_ms = int(self._clock.now().timestamp() * 1000)
        resent, broken = getattr(line, "resent", 0), getattr(line, "broken", 0)
        bus.publish_trace(self._slug, Trace(direction, data.hex(" "), words, at_ms, resent, broken))
