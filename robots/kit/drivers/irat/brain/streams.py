"""The byte streams of the map, of the pose cells and of the map before this one. Their format: the robot's README.

A key packet holds everything, a delta what changed since the packet before.
"""

import logging
import math
import struct
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from robots.kit.clock import SYSTEM, ms_of
from robots.kit.drivers.irat.packets import DOCK, DOCKS, EARLIER, HEAD, LEVELS, PLACE, ROUTE, UNIT_M, VERSION, Why
from robots.kit.files import replaced
from robots.kit.slam.slam import RatSlam

log = logging.getLogger(__name__)
Grid = NDArray[np.int16]
Dock = tuple[int, int, int]
NO_DOCK: Dock = (0, 0, 0)
MOVED = 4  # units; the dock's place is sent again only if it moved by so much


class MapStream:
    """The stream `map`: experiences, links, the route (its last is the goal), places that saw the dock, the dock."""

    def __init__(self) -> None:
        self._map, self._last = -1, -1  # number and sequence that were sent
        self._places: dict[int, tuple[int, int]] = {}
        self._route: tuple[int, ...] = ()
        self._docks: tuple[int, ...] = ()
        self._dock = NO_DOCK
        self.key = True  # the next one holds everything

    def next(
        self, slam: RatSlam, route: tuple[int, ...], dock: tuple[float, float] | None = None, closed_m: float = 0.0
    ) -> tuple[bytes, bool] | None:
        """Return the next packet and whether it is a key packet; None if nothing has changed.

        dock: its x and y (m) on the map, if known; within `closed_m` of it only docking leads.
        """
        docks = tuple(sorted(slam.docks.places))
        at = _dock(dock, closed_m)
        if math.dist(at, self._dock) < MOVED:
            at = self._dock
        if self.key or slam.map_number != self._map:
            self._last = -1
        if self._last == slam.sequence and (route, docks, at) == (self._route, self._docks, self._dock):
            return None
        changes = slam.since(self._last)
        if changes.whole:
            self._places = {}
        places: Grid = np.clip(np.rint(changes.poses[:, :2] / UNIT_M), -32768, 32767).astype(np.int16)
        told = [n for n, (i, at) in enumerate(zip(changes.ids.tolist(), places.tolist(), strict=True))
                if self._places.get(i) != tuple(at)]  # fmt: skip
        self._places |= {int(changes.ids[n]): (int(places[n, 0]), int(places[n, 1])) for n in told}
        flags = (
            (ROUTE if changes.whole or route != self._route else 0)
            | (DOCKS if changes.whole or docks != self._docks else 0)
            | (DOCK if at != (NO_DOCK if changes.whole else self._dock) else 0)
        )
        self._map, self._last, self.key = slam.map_number, slam.sequence, False
        self._route, self._docks, self._dock = route, docks, at
        if not (changes.whole or told or len(changes.links) or flags):
            return None
        data = HEAD.pack(VERSION, flags, slam.map_number, len(told), len(changes.links))
        data += changes.ids[told].astype("<u4").tobytes() + places[told].T.astype("<i2").tobytes()
        data += changes.links.astype("<u4").tobytes()
        data += _ids(route) if flags & ROUTE else b""
        data += _ids(docks) if flags & DOCKS else b""
        return data + (PLACE.pack(*at) if flags & DOCK else b""), changes.whole


def _dock(at: tuple[float, float] | None, closed_m: float) -> Dock:
    if at is None:
        return NO_DOCK
    x, y = (max(-32768, min(32767, round(v / UNIT_M))) for v in at)
    return x, y, max(1, min(65535, round(closed_m / UNIT_M)))


def _ids(ids: tuple[int, ...]) -> bytes:
    return struct.pack("<H", len(ids)) + np.array(ids, "<u4").tobytes()


@dataclass
class CellStream:
    """The activity of the pose cells: for each that changed a u16, its number times 8 plus its level, 0 to 7."""

    key: bool = True

    def __post_init__(self) -> None:
        """Begin with silent cells."""
        self._levels = np.zeros(0, np.uint16)

    def next(self, cells: NDArray[np.float64]) -> tuple[bytes, bool] | None:
        """Return the next packet and whether it is a key packet; None if nothing has changed."""
        flat = cells.reshape(-1)
        levels = np.rint(flat * (LEVELS / max(float(flat.max()), 1e-300))).astype(np.uint16)
        key = self.key or len(self._levels) != len(levels)
        changed = np.flatnonzero(levels if key else levels != self._levels)
        self._levels, self.key = levels, False
        if not (key or len(changed)):
            return None
        return (changed.astype(np.uint16) << 3 | levels[changed]).astype("<u2").tobytes(), key


class EarlierMap:
    """The map before this one, with the reason and the time of its end, for people who miss it.

    Keeps the packet of the byte stream `earlier` in a file, so that it outlives the process.
    """

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
