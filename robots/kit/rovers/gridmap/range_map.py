"""The map in grid cells: the expected reading of the sonar in each of them, for each heading, computed once."""

from dataclasses import dataclass
from math import tau

import numpy as np
from numpy.typing import NDArray

from robots.kit.rovers.gridmap.plan import Floats, Plan, RangeSensor

CELL_M = 0.30  # the measured optimum: see docs/explanation/grid-scan.md
BINS = 72  # headings, each 5 degrees
LEVEL_M = 0.01  # of the stored ranges
ROOM_M = 0.10  # that the middle of the rover leaves to surfaces at least
BESIDE = 0.4  # of a cell's size: how far from its middle it is looked for a place where the rover fits


@dataclass(frozen=True)
class RangeMap:
    """`sonar` (2 bins, cells): levels of LEVEL_M; `free` (ny, nx): where the rover can be; `plan`: the map itself.

    The table has all headings twice, so that those from any of them on are one block, and the free cells alone.

    The middle of cell (0, 0) is half a cell from the corner `origin` (m). Heading 0 is the middle of bin 0. `place`
    (ny, nx, 2): the x and y for which a cell's readings are; its middle, or if that is inside of something, beside it.
    """

    plan: Plan
    sonar_sensor: RangeSensor
    infrared_sensor: RangeSensor
    cell: float
    bins: int
    origin: tuple[float, float]
    sonar: NDArray[np.uint16]
    free: NDArray[np.bool_]
    place: Floats

    @classmethod
    def of(
        cls, plan: Plan, sonar: RangeSensor, infrared: RangeSensor, cell: float = CELL_M, bins: int = BINS
    ) -> "RangeMap":
        """Return the map in cells of `cell` m and `bins` headings. Raises ValueError for sizes out of bounds."""
        x0, y0, x1, y1 = plan.extent
        if not (0.02 <= cell <= 2.0 and 8 <= bins <= 720 and (x1 - x0) * (y1 - y0) / cell**2 <= 1e6):
            raise ValueError("A cell has 0.02 to 2 m, there are 8 to 720 headings, and at most a million cells.")
        xs = x0 + cell * (np.arange(int(np.ceil((x1 - x0) / cell - 1e-9))) + 0.5)
        ys = y0 + cell * (np.arange(int(np.ceil((y1 - y0) / cell - 1e-9))) + 0.5)
        x, y = (a.ravel() for a in np.meshgrid(xs, ys))
        corners = BESIDE * cell * np.array([[0, 0], [-1, -1], [-1, 1], [1, -1], [1, 1]])
        room = np.stack([plan.room(x + dx, y + dy) for dx, dy in corners])
        best = corners[np.where(room[0] > ROOM_M, 0, room.argmax(0))]
        x, y, free = x + best[:, 0], y + best[:, 1], room.max(0) > ROOM_M
        table = np.empty((2 * bins, int(free.sum())), np.uint16)
        for number in range(bins):  # one heading after another stays in the processor's cache
            heading = np.full(table.shape[1], number * tau / bins)
            table[number] = table[bins + number] = np.round(plan.nearest(x[free], y[free], heading, sonar) / LEVEL_M)
        shape = len(ys), len(xs)
        place = np.stack([x, y], 1).reshape(*shape, 2)
        return cls(plan, sonar, infrared, cell, bins, (x0, y0), table, free.reshape(shape), place)

    @property
    def shape(self) -> tuple[int, int, int]:
        """Return the numbers of headings, rows and columns."""
        return self.bins, self.free.shape[0], self.free.shape[1]

    @property
    def x(self) -> Floats:
        """Return the middles of the columns (m)."""
        return np.asarray(self.origin[0] + self.cell * (np.arange(self.free.shape[1]) + 0.5), float)

    @property
    def y(self) -> Floats:
        """Return the middles of the rows (m)."""
        return np.asarray(self.origin[1] + self.cell * (np.arange(self.free.shape[0]) + 0.5), float)

    @property
    def headings(self) -> Floats:
        """Return the middles of the bins (rad, from 0)."""
        return np.arange(self.bins) * tau / self.bins
