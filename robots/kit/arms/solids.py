"""Boxes in any rotation around an arm: which lie on, over or in each other. Lengths in m, in the frame of the base."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from robots.kit.arms.chain import Matrix

CORNERS = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
TOUCH_M = 0.002  # surfaces this close touch: a model of what lies where is no more exact


@dataclass(frozen=True, eq=False)
class Solid:
    """A box: the pose of its middle (4 x 4), and half its edges."""

    pose: Matrix
    half: tuple[float, float, float]

    @cached_property
    def corners(self) -> Matrix:
        """Return its corners, (8, 3)."""
        found: Matrix = self.pose[:3, 3] + (CORNERS * self.half) @ self.pose[:3, :3].T
        return found

    @property
    def bottom(self) -> float:
        """Return the height of its lowest point."""
        return float(self.corners[:, 2].min())

    @property
    def top(self) -> float:
        """Return the height of its highest point."""
        return float(self.corners[:, 2].max())

    @property
    def radius(self) -> float:
        """Return how far a corner is from the middle at most, seen from above."""
        return float(np.linalg.norm(self.corners[:, :2] - self.pose[:2, 3], axis=1).max())

    @cached_property
    def _normals(self) -> Matrix:
        """Return the directions (n, 2) across its edges, seen from above, each of length one."""
        along = self.pose[:2, :3].T
        across = np.stack([-along[:, 1], along[:, 0]], axis=1)
        lengths = np.linalg.norm(across, axis=1)
        found: Matrix = across[lengths > 1e-6] / lengths[lengths > 1e-6, None]
        return found


def cover(one: Solid, other: Solid, slack: float = TOUCH_M) -> bool:
    """Return whether one lies over the other, seen from above, by more than `slack`.

    The outline of a box from above is convex with edges along its own axes, so one of their normals separates two
    outlines that do not overlap.
    """
    for normal in np.concatenate([one._normals, other._normals]):
        a, b = one.corners[:, :2] @ normal, other.corners[:, :2] @ normal
        if min(a.max(), b.max()) - max(a.min(), b.min()) <= slack:
            return False
    return True


def overlap(one: Solid, other: Solid, slack: float = TOUCH_M) -> bool:
    """Return whether two solids are in each other by more than `slack`; one that leans counts as an upright prism."""
    return min(one.top, other.top) - max(one.bottom, other.bottom) > slack and cover(one, other, slack)


def rests_on(upper: Solid, lower: Solid) -> bool:
    """Return whether the upper one touches the top of the lower one."""
    return abs(upper.bottom - lower.top) <= TOUCH_M and cover(upper, lower)


def is_over(solid: Solid, x: float, y: float) -> bool:
    """Return whether a point lies inside the outline of a solid, seen from above."""
    for normal in solid._normals:
        along, at = solid.corners[:, :2] @ normal, normal @ np.array([x, y])
        if not along.min() <= at <= along.max():
            return False
    return True
