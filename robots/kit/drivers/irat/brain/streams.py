"""The byte streams of the map and of the pose cells, in few bytes. Their format: the robot's README.

A key packet holds everything, a delta what changed since the packet before.
"""

import math
import struct
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robots.kit.drivers.irat.packets import DOCK, DOCKS, HEAD, LEVELS, PLACE, ROUTE, UNIT_M, VERSION
from robots.kit.slam.slam import RatSlam

Grid = NDArray[np.int16]
Dock = tuple[int, int, int]
NO_DOCK: Dock = (0, 0, 0)
MOVED = 4  # units; by less the dock's place is not told again


class MapStream:
    """Experiences, links, the way to the goal (whose last is the goal), from where the dock was seen, where it is."""

    def __init__(self) -> None:
        self._map, self._last = -1, -1  # number and sequence that were told
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
