"""Byte streams of the map and of the pose cells, decoded: the picture so far and a packet give the next picture."""

import struct
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from robots.kit.drivers.irat.packets import DOCK, DOCKS, HEAD, LEVELS, PLACE, ROUTE, UNIT_M, VERSION
from robots.kit.slam.settings import CellSettings

Ids = NDArray[np.int64]
Places = NDArray[np.float64]
Levels = NDArray[np.uint8]
_CELLS = CellSettings()
SHAPE = (_CELLS.around, _CELLS.across, _CELLS.across)  # heading, y, x
MOST = 100_000  # experiences or links of a map


def _no_ids() -> Ids:
    return np.zeros(0, np.int64)


@dataclass(frozen=True)
class MapShown:
    """A map: ids of its experiences, rising, with their places (n x 2, m); links (m x 2, ids); route; docks (ids).

    dock: x, y of the dock (m), and within how much of it (m) only docking leads; None while not known.
    """

    number: int = 0
    ids: Ids = field(default_factory=_no_ids)
    places: Places = field(default_factory=lambda: np.zeros((0, 2)))
    links: Ids = field(default_factory=lambda: np.zeros((0, 2), np.int64))
    route: Ids = field(default_factory=_no_ids)
    docks: Ids = field(default_factory=_no_ids)
    dock: tuple[float, float, float] | None = None

    def where(self, ids: Ids) -> Places:
        """Return the places (m) of those ids that are on the map, in their order."""
        rows, known = self._rows(ids)
        return self.places[rows[known]]

    def ends(self) -> Places:
        """Return both ends (k x 2 x 2, m) of each link between experiences that are on the map."""
        rows, known = self._rows(self.links)
        return self.places[rows[known.all(axis=1)]]

    def _rows(self, ids: Ids) -> tuple[Ids, NDArray[np.bool_]]:
        if not len(self.ids):
            return np.zeros(ids.shape, np.int64), np.zeros(ids.shape, np.bool_)
        rows = np.minimum(np.searchsorted(self.ids, ids), len(self.ids) - 1)
        return rows, self.ids[rows] == ids


def with_map(previous: MapShown, data: bytes, key: bool) -> MapShown:
    """Return the map after a packet of its stream. Raises ValueError for one that cannot be read."""
    try:
        version, flags, number, n, m = HEAD.unpack_from(data)
        if version != VERSION or n > MOST or m > MOST:
            raise ValueError("this is no packet of a map")
        ids = np.frombuffer(data, "<u4", n, HEAD.size).astype(np.int64)
        places = np.frombuffer(data, "<i2", 2 * n, HEAD.size + 4 * n).reshape(2, n).T * UNIT_M
        at = HEAD.size + 8 * n
        links = np.frombuffer(data, "<u4", 2 * m, at).astype(np.int64).reshape(m, 2)
        at += 8 * m
        lists = []
        for flag, before in ((ROUTE, previous.route), (DOCKS, previous.docks)):
            if flags & flag:
                (count,) = struct.unpack_from("<H", data, at)
                lists.append(np.frombuffer(data, "<u4", count, at + 2).astype(np.int64))
                at += 2 + 4 * count
            else:
                lists.append(_no_ids() if key else before)
        (route, docks), dock = lists, None if key else previous.dock
        if flags & DOCK:
            x, y, within = PLACE.unpack_from(data, at)
            dock = (x * UNIT_M, y * UNIT_M, within * UNIT_M) if within else None
    except struct.error as error:
        raise ValueError("this is no packet of a map") from error
    if key:
        previous = MapShown()
    elif len(previous.links) + m > MOST or len(previous.ids) + n > MOST:
        raise ValueError("this map is too large")
    # the last place of an id counts; np.unique returns the first one, so the newest come first
    newest, first = np.unique(np.concatenate([ids[::-1], previous.ids]), return_index=True)
    everywhere = np.concatenate([places[::-1], previous.places])[first]
    return MapShown(number, newest, everywhere, np.concatenate([previous.links, links]), route, docks, dock)


def with_cells(previous: Levels, data: bytes, key: bool) -> Levels:
    """Return the levels (0 to 7) of the pose cells, heading x y x x, after a packet of their stream.

    Raises ValueError for one that cannot be read.
    """
    if len(data) % 2:
        raise ValueError("this is no packet of pose cells")
    told = np.frombuffer(data, "<u2")
    numbers = told >> 3
    flat = np.zeros(int(np.prod(SHAPE)), np.uint8) if key else previous.reshape(-1).copy()
    if len(numbers) and int(numbers.max()) >= len(flat):
        raise ValueError("there is no such pose cell")
    flat[numbers] = np.minimum(told & 7, LEVELS)
    return flat.reshape(SHAPE)


def silent() -> Levels:
    """Return pose cells of which none is active."""
    return np.zeros(SHAPE, np.uint8)
