"""The map before this one, for people who miss it, with the reason and the time of its end."""

import logging
from pathlib import Path

from robots.kit.clock import SYSTEM, ms_of
from robots.kit.drivers.irat.brain.streams import MapStream
from robots.kit.drivers.irat.packets import EARLIER, HEAD, VERSION, Why
from robots.kit.files import replaced
from robots.kit.slam.slam import RatSlam

log = logging.getLogger(__name__)


class EarlierMap:
    """Keeps the packet of the byte stream `earlier` in a file, so that it outlives the process."""

    def __init__(self, path: Path) -> None:
        self._path, self.key = path, True  # the packet is to be sent
        try:
            self._packet = path.read_bytes()
        except OSError:
            self._packet = b""

    def was(self, slam: RatSlam, dock: tuple[float, float] | None, closed_m: float, age_s: float, why: Why) -> None:
        """Take in the map that is about to be cleared."""
        told = MapStream().next(slam, (), dock, closed_m)
        assert told is not None  # the first packet of a stream holds everything
        self._take(told[0], age_s, why)

    def was_lost(self, number: int, age_s: float) -> None:
        """Note that a map could not be read."""
        self._take(HEAD.pack(VERSION, 0, number, 0, 0), age_s, Why.LOST)

    def _take(self, data: bytes, age_s: float, why: Why) -> None:
        self._packet, self.key = EARLIER.pack(VERSION, why, age_s, ms_of(SYSTEM.now())) + data, True
        try:
            with replaced(self._path) as out:
                out.write(self._packet)
        except OSError as error:
            log.warning("the map before this one is not kept: %s", error)

    def next(self) -> bytes | None:
        """Return the packet if it is to be sent."""
        wanted, self.key = self.key, False
        return self._packet if wanted and self._packet else None
