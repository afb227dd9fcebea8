"""Finds square markers of a dictionary of one's own in a grey picture, and where they are (OpenCV's ArUco detector).

A dictionary of few bits has large cells, and an enlarged picture gives the detector's thresholds and corners room: so
a marker of seven pixels is read, where one of a stock dictionary of 4 x 4 bits is not.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from robots.kit.rovers.docking import Sighting

Grey = NDArray[np.uint8]
Bits = Sequence[Sequence[int]]


@dataclass(frozen=True)
class Marker:
    """A marker in the picture. `corners`: (4, 2), pixels, clockwise from the code's upper left."""

    number: int
    corners: NDArray[np.float64]
    sighting: Sighting


class Markers:
    """A set of codes with the side of each (m), as seen by a camera of a given horizontal field of view (rad).

    `bits`: rows of 0 (black) and 1 (white) of each code, square, without the black border. `inside`: numbers of those
    printed in a white cell of another, which they hide from the detector. Lens without distortion.
    """

    def __init__(
        self,
        bits: Mapping[int, Bits],
        sides: Mapping[int, float],
        field: float,
        inside: frozenset[int] = frozenset(),
        enlarge: int = 3,
    ) -> None:
        if bits.keys() != sides.keys() or not bits:
            raise ValueError("each code needs the side of its marker.")
        self._numbers, self._sides, self._field, self._enlarge = sorted(bits), dict(sides), field, enlarge
        self._inside = inside
        codes = [np.array(bits[n], np.uint8) for n in self._numbers]
        size = len(codes[0])
        if any(code.shape != (size, size) for code in codes):
            raise ValueError("the codes must be square and of one size.")
        listed = np.concatenate([cv2.aruco.Dictionary.getByteListFromBits(code) for code in codes])
        settings = cv2.aruco.DetectorParameters()
        settings.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_CONTOUR  # tells the angle best
        settings.adaptiveThreshWinSizeMin, settings.adaptiveThreshWinSizeMax = 7, 31
        settings.adaptiveThreshWinSizeStep = 12
        settings.minMarkerPerimeterRate = 0.02
        settings.polygonalApproxAccuracyRate = 0.06  # corners of a marker of seven pixels are round
        settings.perspectiveRemovePixelPerCell = 8
        settings.minGroupDistance = 0.01
        settings.errorCorrectionRate = 0.0  # a wrong bit is another thing on the wall
        settings.maxErroneousBitsInBorderRate = 0.25
        self._detector = cv2.aruco.ArucoDetector(cv2.aruco.Dictionary(listed, size, 0), settings)

    def find(self, picture: Grey) -> list[Marker]:
        """Return the markers in a grey picture, (height, width). Raises ValueError for another picture."""
        if picture.ndim != 2 or picture.dtype != np.uint8 or min(picture.shape) < 8:
            raise ValueError(f"a grey picture of 8 bits is needed, not {picture.dtype} of shape {picture.shape}.")
        by = self._enlarge
        large: Grey = np.asarray(cv2.resize(picture, None, fx=by, fy=by, interpolation=cv2.INTER_CUBIC), np.uint8)
        found = self._detect(large, picture.shape)
        hiding = [marker for marker in found if marker.number in self._inside]
        if hiding and len(hiding) == len(found):
            for marker in hiding:
                self._paint_over(large, marker)
            found += [marker for marker in self._detect(large, picture.shape) if marker.number not in self._inside]
        return found

    def _detect(self, large: Grey, shape: tuple[int, ...]) -> list[Marker]:
        corners, numbers, _ = self._detector.detectMarkers(large)
        if numbers is None:
            return []
        pairs = zip(np.asarray(numbers).reshape(-1), corners, strict=True)
        found = [self._placed(self._numbers[int(n)], np.asarray(c, float).reshape(4, 2), shape) for n, c in pairs]
        return [marker for marker in found if marker is not None]

    def _paint_over(self, large: Grey, marker: Marker) -> None:
        """Fill a marker and a little around it with the white of its cell."""
        corners = (marker.corners + 0.5) * self._enlarge - 0.5
        centre = corners.mean(axis=0)
        patch = np.round(centre + 1.12 * (corners - centre)).astype(np.int32)
        rows = np.clip(patch[:, 1], 0, large.shape[0] - 1)
        white = int(large[rows, np.clip(patch[:, 0], 0, large.shape[1] - 1)].max())
        cv2.fillConvexPoly(large, patch, (white,))

    def _placed(self, number: int, corners: NDArray[np.float64], shape: tuple[int, ...]) -> Marker | None:
        """Return the marker with its place, None if its corners fit no square before the camera."""
        height, width = shape
        pixels = (corners + 0.5) / self._enlarge - 0.5
        focal = width / 2 / math.tan(self._field / 2)
        camera = np.array([[focal, 0, (width - 1) / 2], [0, focal, (height - 1) / 2], [0, 0, 1.0]])
        half = self._sides[number] / 2
        square = np.array([[-half, half, 0], [half, half, 0], [half, -half, 0], [-half, -half, 0]])
        done, turn, shift = cv2.solvePnP(square, pixels, camera, None, flags=cv2.SOLVEPNP_IPPE_SQUARE)
        if not done or not np.isfinite(shift).all() or shift[2, 0] <= 0:
            return None
        rotation = cv2.Rodrigues(turn)[0]
        seat = -rotation.T @ shift[:, 0]  # the camera in the marker's frame: x right, y up, z out of it
        centre = shift[:, 0] / shift[2, 0] * focal / (width / 2)
        sighting = Sighting(float(centre[0]), float(shift[2, 0]), math.atan2(float(-seat[0]), float(seat[2])))
        return Marker(number, pixels, sighting)
