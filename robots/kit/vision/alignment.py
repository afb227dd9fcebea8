"""Finds the corners of a printed marker to about a tenth of a pixel: by aligning its whole print with the picture.

OpenCV's ECC (Evangelidis and Psarakis 2008), which brightness and contrast do not change. A detector's own corners lie
where a threshold had the border, a third of a pixel outside or inside. The picture is brought into the frame of the
print first, and the rest is an affine motion there: a marker of ten pixels does not tell a perspective.
"""

from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

Grey = NDArray[np.uint8]
Floats = NDArray[np.float64]
CELL = 4  # pixels of a cell of the print that is compared
BLUR = 0.35  # of a cell, as a lens has it
MARGIN_PX = 3 * CELL  # of the picture around the print
MARGIN = np.array([[1.0, 0.0, -MARGIN_PX], [0.0, 1.0, -MARGIN_PX], [0.0, 0.0, 1.0]])
SHIFTS_PX = [np.array([x, y]) for x in range(-2, 3) for y in range(-2, 3)]
ROUNDS = 30, 1e-5  # of the alignment, at most; change after which it ends
SURE, READ_SURE = 0.92, 0.9  # correlation from which this is the marker; from which it is one that was read
HINT = 0.7  # from which it may be
TRIED = 0.5  # from which it is worth an alignment


class Template:
    """A marker's print: `bits` (n, n), 1 is white, in a black border of one cell and a white margin of half one."""

    def __init__(self, bits: NDArray[np.uint8]) -> None:
        cells = 255 * np.pad(bits, 1)
        large = np.kron(cells, np.ones((CELL, CELL), np.uint8))
        padded = np.pad(large, CELL // 2, constant_values=245).astype(np.float32)
        self._print = cv2.GaussianBlur(padded, (0, 0), BLUR * CELL)
        low, high = CELL / 2 - 0.5, CELL / 2 + len(large) - 0.5
        self._corners = np.array([[low, low], [high, low], [high, high], [low, high]])

    @cached_property
    def _size(self) -> tuple[int, int]:
        return self._print.shape[1], self._print.shape[0]

    def likeness(self, picture: Grey, corners: Floats) -> float:
        """Return the correlation of the print with the picture where its corners (4, 2) would be; -1 where none is."""
        seen = cv2.warpPerspective(
            picture, self._map(corners), self._size, flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        ).astype(np.float32)
        if float(seen.std()) < 1.0:
            return -1.0
        return float(np.corrcoef(seen.ravel(), self._print.ravel())[0, 1])

    def most_alike(self, picture: Grey, corners: Floats) -> Floats:
        """Return where around a place the print is most like the picture: corners (4, 2), moved by whole pixels."""
        return max((corners + by for by in SHIFTS_PX), key=lambda at: self.likeness(picture, at))

    def align(self, picture: Grey, corners: Floats, sure: float = SURE) -> Floats | None:
        """Return the corners (4, 2) in the picture (px), from about where they are; None where the print is not.

        `sure`: the least correlation.
        """
        if not np.isfinite(corners).all() or self.likeness(picture, corners) < TRIED:
            return None
        (wide, high), there = self._size, self._map(corners) @ MARGIN
        part = cv2.warpPerspective(
            picture, there, (wide + 2 * MARGIN_PX, high + 2 * MARGIN_PX), flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        ).astype(np.float32)
        begin = np.linalg.inv(MARGIN)[:2].astype(np.float32)
        criteria = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, *ROUNDS)
        whole = np.full(part.shape, 255, np.uint8)
        try:
            likeness, found = cv2.findTransformECC(self._print, part, begin, cv2.MOTION_AFFINE, criteria, whole, 1)
        except cv2.error:  # it does not come to an end, or leaves the picture
            return None
        if not likeness >= sure:
            return None
        aligned = there @ np.vstack([np.asarray(found, np.float64), [0.0, 0.0, 1.0]])
        return np.asarray(cv2.perspectiveTransform(self._corners[None], aligned)[0])

    def _map(self, corners: Floats) -> Floats:
        """Return the homography (3 x 3) from the print to the picture."""
        return np.asarray(cv2.getPerspectiveTransform(self._corners.astype(np.float32), corners.astype(np.float32)))
