"""Figures of the byte streams' format, for their writer and their readers."""

import struct
from enum import IntEnum

VERSION = 1
HEAD = struct.Struct("<BBIII")
ROUTE, DOCKS, DOCK = 1, 2, 4
PLACE = struct.Struct("<hhH")  # of the dock, and how far around it only docking leads; in units
# before the map that was cleared: version, why, its age (s), when (ms since 1970)
EARLIER = struct.Struct("<BBfQ")
UNIT_M = 0.005  # of a position on the map
LEVELS = 7  # of a cell's activity


class Why(IntEnum):
    """Why a map was cleared."""

    AGE = 0  # it was old enough, and no goal waited
    OLDEST = 1  # it was so old that it was cleared although goals waited
    STAFF = 2
    LOST = 3  # it could not be read when the brain was started again
