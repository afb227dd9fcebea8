"""Pose cells: an attractor network whose peak of activity is where the robot believes itself to be."""

import math

import numpy as np

from robots.kit.slam import spreading
from robots.kit.slam.settings import CellSettings

REACH = 3  # cells round the strongest one whose mean is the peak (OpenRatSLAM)
Place = tuple[float, float, float]


class PoseCells:
    """The network, (heading, y, x); never negative, of sum 1 after every step. `best`: the peak, in cells."""

    def __init__(self, settings: CellSettings) -> None:
        self.settings = settings
        self.cells = np.zeros((settings.around, settings.across, settings.across))
        middle = settings.across // 2
        self.cells[settings.around // 2, middle, middle] = 1.0
        self.best: Place = (float(middle), float(middle), float(settings.around // 2))
        self._excite = spreading.line(settings.excite_width, settings.excite_sd)
        self._inhibit = spreading.line(settings.inhibit_width, settings.inhibit_sd)

    def inject(self, place: Place, energy: float) -> None:
        """Add energy at a place, shared linearly between the eight cells round it."""
        around, across, _ = self.cells.shape
        x, y, heading = place
        for k, in_k in _shares(heading, around):
            for j, in_j in _shares(y, across):
                for i, in_i in _shares(x, across):
                    self.cells[k, j, i] += energy * in_k * in_j * in_i

    def step(self, distance_m: float, turn_rad: float) -> None:
        """Let the cells compete, then move their activity as the robot moved."""
        settings = self.settings
        if not spreading.compete(self.cells, self._excite, self._inhibit, settings.inhibit_all):
            self.cells /= self.cells.sum()  # activity was so even that none was left: the cells stay as they were
        spreading.shift(self.cells, distance_m / settings.cell_m, turn_rad * settings.around / (2.0 * math.pi))
        x, y, heading = spreading.peak(self.cells, REACH)
        self.best = (float(x), float(y), float(heading))

    def distances(self, places: np.ndarray) -> np.ndarray:
        """Return the distances (cells) of the peak to places, (n, 3)."""
        sizes = np.array([self.settings.across, self.settings.across, self.settings.around], float)
        apart = np.abs(places - np.asarray(self.best))
        found: np.ndarray = np.sqrt(np.square(np.minimum(apart, sizes - apart)).sum(axis=-1))
        return found


def _shares(at: float, size: int) -> tuple[tuple[int, float], tuple[int, float]]:
    """Return the two cells of an axis next to a position, each with its share."""
    low = math.floor(at)
    part = at - low
    return (low % size, 1.0 - part), ((low + 1) % size, part)
