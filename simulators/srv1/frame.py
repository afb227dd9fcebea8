"""A picture in the memory of the rover's processor, and what its firmware measures in it (`colors.c`).

Two neighbouring pixels share their colour there (UYVY), so a pair of pixels is the smallest unit of a measurement.
"""

from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

Image = NDArray[np.uint8]
Mask = NDArray[np.bool_]
MOST_BLOBS, MOST_EDGES_WIDE = 62, 640  # wider pictures have no edges: its buffer is too small


class Bin(NamedTuple):
    """A range of colours, each bound included; the empty one at first."""

    y1: int = 0
    y2: int = 0
    u1: int = 0
    u2: int = 0
    v1: int = 0
    v2: int = 0


@dataclass(frozen=True)
class Blob:
    """The number of pairs that match, and the rectangle around them (pixels, from left and top)."""

    count: int
    x1: int
    x2: int
    y1: int
    y2: int


class Frame:
    """`picture`: RGB, shape (height, width, 3). `y1`, `y2`, `u`, `v`: of each pair, shape (height, width / 2)."""

    def __init__(self, picture: Image) -> None:
        self.height, self.width = picture.shape[:2]
        y, v, u = (plane.astype(np.int32) for plane in cv2.split(cv2.cvtColor(picture, cv2.COLOR_RGB2YCrCb)))
        self.y1, self.y2, self.u, self.v = y[:, ::2], y[:, 1::2], u[:, ::2], v[:, ::2]
        self.y = (self.y1 + self.y2) >> 1

    def matching(self, of: Bin) -> Mask:
        """Return which pairs are within a range of colours."""
        planes = (self.y, of.y1, of.y2), (self.u, of.u1, of.u2), (self.v, of.v1, of.v2)
        return np.asarray(np.all([(low <= plane) & (plane <= high) for plane, low, high in planes], axis=0))

    def blobs(self, of: Bin) -> list[Blob]:
        """Return the blobs of what matches, largest first; an empty column divides two, isolated pairs are dropped."""
        mask = np.pad(self.matching(of)[1:-1, 1:], 1)
        for _ in range(2):
            _clear_isolated(mask)
        mask = mask[:, :-1]
        columns = np.flatnonzero(mask.any(axis=0))
        found = []
        for run in np.split(columns, np.flatnonzero(np.diff(columns) > 1) + 1) if len(columns) else ():
            part = mask[:, run[0] : run[-1] + 1]
            rows = np.flatnonzero(part.any(axis=1))
            found.append(Blob(int(part.sum()), int(run[0]) * 2, int(run[-1]) * 2, int(rows[0]), int(rows[-1])))
        return sorted(found[:MOST_BLOBS], key=lambda blob: -blob.count)

    def count(self, of: Bin, x1: int, x2: int, y1: int, y2: int) -> int:
        """Return how many pairs of a rectangle match; its right and lower borders are not of it."""
        return int(self.matching(of)[y1:y2, x1 // 2 : (x2 + 1) // 2].sum())

    def mean(self) -> tuple[int, int, int]:
        """Return the mean Y, U and V."""
        y, u, v = (int(plane.sum()) * 2 // self.width // self.height for plane in (self.y, self.u, self.v))
        return y, u, v

    def pixel(self, x: int, y: int) -> tuple[int, int, int]:
        """Return Y, U and V of a pair; outside of the picture the nearest within."""
        at = min(y, self.height - 1), min(x, self.width - 1) // 2
        return int(self.y1[at]), int(self.u[at]), int(self.v[at])

    def histogram(self) -> NDArray[np.int64]:
        """Return how often each of 16 ranges of U comes with each of 16 ranges of V, shape (16, 16)."""
        return np.bincount((self.u.ravel() & 0xF0) + (self.v.ravel() >> 4), minlength=256).reshape(16, 16)

    def edges(self, threshold: int) -> Mask:
        """Return which pairs are on an edge, across or down."""
        found = np.zeros(self.u.shape, np.bool_)
        if self.width > MOST_EDGES_WIDE:
            return found
        for axis in (0, 1):
            strength = sum(_difference(plane, axis) ** 2 for plane in (self.u, self.v))
            strength += _difference(self.y1 + self.y2, axis) ** 2 >> 2
            found[1:-1, 1:-1] |= strength > threshold
        return found


@njit(cache=True, nogil=True)
def _clear_isolated(mask: Mask) -> None:
    """Clear, one after the other, pairs with less than four of their eight neighbours; the border is empty."""
    for row in range(1, mask.shape[0] - 1):
        for column in range(1, mask.shape[1] - 1):
            if mask[row, column] and mask[row - 1 : row + 2, column - 1 : column + 2].sum() < 5:
                mask[row, column] = False


def _difference(plane: NDArray[np.int32], axis: int) -> NDArray[np.int32]:
    """Return the difference of the two neighbours of each pair but those at the border."""
    return plane[2:, 1:-1] - plane[:-2, 1:-1] if axis == 0 else plane[1:-1, 2:] - plane[1:-1, :-2]
