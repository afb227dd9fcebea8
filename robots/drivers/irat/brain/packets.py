"""The figures of the byte streams' format, for who writes them and who reads them."""

import struct

VERSION = 1
HEAD = struct.Struct("<BBIII")
ROUTE, DOCKS, DOCK = 1, 2, 4
PLACE = struct.Struct("<hhH")  # of the dock, and how far around it only docking leads; in units
UNIT_M = 0.005  # of a position on the map
LEVELS = 7  # of a cell's activity
