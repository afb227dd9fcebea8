"""The markers that are printed on the objects of a `robot.toml`, and its fixed, calibrated cameras. Lengths in m.

`[markers] dictionary` names one of OpenCV's; `markers` of an `[[object]]` says where each is; `[[view]]` where a camera
is, and where it looks. The printed square has a white margin of half a cell around the marker's black border.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from math import radians, tan
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Print:
    """A marker on an object: its number and side; in the object's frame its middle, its right and its upper way."""

    number: int
    side: float
    middle: Floats
    right: Floats
    upward: Floats

    @cached_property
    def corners(self) -> Floats:
        """Return the corners (4, 3) in the object's frame, clockwise from the code's upper left."""
        half = self.side / 2
        signs = np.array([(-1, 1), (1, 1), (1, -1), (-1, -1)], np.float64)
        return np.asarray(self.middle + half * (signs[:, :1] * self.right + signs[:, 1:] * self.upward))

    @property
    def out(self) -> Floats:
        """Return the way (3,) out of its face."""
        return np.cross(self.right, self.upward)


@dataclass(frozen=True, eq=False)
class FixedCamera:
    """A camera without distortion; `towards` (4 x 4) leads from the base's frame to its: x right, y down, z forward.

    `size`: width and height of its pictures (px); `focal` length (px).
    """

    name: str
    towards: Floats
    size: tuple[int, int]
    focal: float

    @property
    def matrix(self) -> Floats:
        """Return the camera matrix (3 x 3) for OpenCV, whose pixel 0 is about 0."""
        width, height = self.size
        return np.array([[self.focal, 0.0, (width - 1) / 2], [0.0, self.focal, (height - 1) / 2], [0.0, 0.0, 1.0]])

    @property
    def seat(self) -> Floats:
        """Return where the lens is (3,) in the base's frame."""
        return np.asarray(-self.towards[:3, :3].T @ self.towards[:3, 3])

    @property
    def field(self) -> float:
        """Return the horizontal field of view (rad)."""
        return float(2 * np.arctan(self.size[0] / 2 / self.focal))

    def project(self, points: Floats) -> Floats:
        """Return the pixels (..., 2) of points (..., 3) in the base's frame; NaN behind the lens."""
        seen = (points @ self.towards[:3, :3].T + self.towards[:3, 3]) @ self.matrix.T
        depth = np.where(seen[..., 2:] > 0.0, seen[..., 2:], np.nan)
        return np.asarray(seen[..., :2] / depth)

    def on_level(self, at: Floats, height: float) -> Floats:
        """Return the place (3,) at a height (m) that is seen at a pixel (2,); NaN where the way leads to none."""
        way = self.towards[:3, :3].T @ np.linalg.solve(self.matrix, np.array([at[0], at[1], 1.0]))
        far = (height - self.seat[2]) / way[2] if way[2] else np.nan
        return np.asarray(self.seat + (far if far > 0.0 else np.nan) * way)


def cameras_of(description: Mapping[str, Any]) -> tuple[FixedCamera, ...]:
    """Return the calibrated cameras of a description, none where it has no `[[view]]`."""
    return tuple(_camera(table, description["camera"]) for table in description.get("view", ()))


def _camera(view: Mapping[str, Any], camera: Mapping[str, Any]) -> FixedCamera:
    seat, at = (np.array(view[name], np.float64) for name in ("place", "at"))
    forward = (at - seat) / np.linalg.norm(at - seat)
    right = np.cross(forward, (0.0, 0.0, 1.0))
    right /= np.linalg.norm(right)
    towards = np.eye(4)
    towards[:3, :3] = right, np.cross(forward, right), forward
    towards[:3, 3] = -towards[:3, :3] @ seat
    size = int(camera["width"]), int(camera["height"])
    return FixedCamera(view["name"], towards, size, size[0] / 2 / tan(radians(view["field_deg"]) / 2))


def prints_of(description: Mapping[str, Any]) -> dict[str, tuple[Print, ...]]:
    """Return the markers on each object that has some, by its name. Raises ValueError for a number on two faces."""
    found = {one["name"]: tuple(map(_print, one.get("markers", ()))) for one in description.get("object", ())}
    numbers = [one.number for prints in found.values() for one in prints]
    if len(set(numbers)) < len(numbers):
        raise ValueError("a marker's number stands on two faces")
    return {name: prints for name, prints in found.items() if prints}


def _print(table: Mapping[str, Any]) -> Print:
    middle, right, upward = (np.array(table[name], np.float64) for name in ("middle", "right", "upward"))
    return Print(int(table["number"]), float(table["side"]), middle, right, upward)


def codes_of(description: Mapping[str, Any]) -> dict[int, NDArray[np.uint8]]:
    """Return the bits of the dictionary's codes, 1 is white, by number; none where there are no markers."""
    if "markers" not in description:
        return {}
    known = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, description["markers"]["dictionary"]))
    return {
        number: np.asarray(cv2.aruco.Dictionary.getBitsFromByteList(listed[None], known.markerSize), np.uint8)
        for number, listed in enumerate(known.bytesList)
    }
