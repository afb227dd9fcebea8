"""The plate with studs on which an arm's objects are put: the table `[plate]` of a description. Lengths in m. Pure."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeGuard

import numpy as np

from robots.kit.arms.chain import Matrix
from robots.kit.arms.solids import Solid
from robots.kit.arms.tables import BadDescription, Three, number, table_of, three

PLATE = "plate"  # its name in tasks
MOST_STUDS = 99
LARGEST_M = 2.0


@dataclass(frozen=True, eq=False)
class Plate:
    """A level plate along the axes of the base: the middle of its underside, and how thick it is without its studs.

    `studs`: columns along x and rows along y, both counted from 1 at the corner with the lowest x and y; `pitch` is
    between two of them.
    """

    place: Three
    studs: tuple[int, int]
    pitch: float
    thick: float

    @cached_property
    def solid(self) -> Solid:
        """Return its box, whose top is where objects lie: studs go into what is pressed on."""
        columns, rows = self.studs
        return Solid(self.pose, (columns * self.pitch / 2, rows * self.pitch / 2, self.thick / 2))

    @cached_property
    def pose(self) -> Matrix:
        """Return the pose (4 x 4) of its middle."""
        pose = np.eye(4)
        pose[:3, 3] = self.place + np.array([0.0, 0.0, self.thick / 2])
        return pose

    @property
    def top(self) -> float:
        """Return the height on which objects lie."""
        return self.place[2] + self.thick

    def middle(self, stud: tuple[int, int], solid: Solid) -> tuple[float, float]:
        """Return where the middle of a box comes that covers this stud with its corner of lowest column and row."""
        low, high = solid.corners[:, :2].min(axis=0), solid.corners[:, :2].max(axis=0)
        corner = np.array(self.place[:2]) + self.pitch * (np.array(stud) - 1 - np.array(self.studs) / 2)
        x, y = corner + (high - low) / 2
        return float(x), float(y)

    def bears(self, solid: Solid) -> bool:
        """Return whether a box is over the plate with its whole outline."""
        low, high = self.solid.corners[:, :2].min(axis=0), self.solid.corners[:, :2].max(axis=0)
        return bool((solid.corners[:, :2] > low - 1e-6).all() and (solid.corners[:, :2] < high + 1e-6).all())


def are_studs(value: Any) -> TypeGuard[list[int]]:
    """Return whether a value of a table is a number of columns and one of rows."""
    return isinstance(value, list) and len(value) == 2 and all(type(n) is int and 1 <= n <= MOST_STUDS for n in value)


def plate_in(description: Mapping[str, Any]) -> Plate | None:
    """Return the plate of a description, None if it has none. Raises BadDescription."""
    if PLATE not in description:
        return None
    table = table_of(description, PLATE)
    studs = table.get("studs")
    if not are_studs(studs):
        raise BadDescription(f"plate: studs is two whole numbers from 1 to {MOST_STUDS}, columns and rows")
    pitch, thick = (number("plate", table, name) for name in ("pitch_m", "thick_m"))
    if not (pitch > 0.0 and thick > 0.0 and pitch * max(studs) <= LARGEST_M):
        raise BadDescription(f"plate: pitch_m and thick_m are above zero, and the plate at most {LARGEST_M:g} m long")
    return Plate(three("plate", table, "place"), (studs[0], studs[1]), pitch, thick)
