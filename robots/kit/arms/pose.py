"""Poses as people write them: a position and three angles.

RPY: roll, pitch, yaw about the fixed axes x, y, z in that order (Craig 1986, section 2.8,
"X-Y-Z fixed angles"). Euler: Z-Y-Z, each about the axis as turned so far (ibid.). The paper (Dziemian et al. 2004)
names both and gives no convention for either.
"""

import numpy as np
from scipy.spatial.transform import Rotation

from robots.kit.arms.chain import Matrix

RPY, EULER = "xyz", "ZYZ"
Six = tuple[float, float, float, float, float, float]


def matrix(values: Six, angles: str = RPY) -> Matrix:
    """Return the (4, 4) pose of (x, y, z in m, three angles in rad)."""
    pose = np.eye(4)
    pose[:3, 3] = values[:3]
    pose[:3, :3] = Rotation.from_euler(angles, values[3:]).as_matrix()
    return pose


def apart(one: Matrix, other: Matrix) -> float:
    """Return how far (m) the middles of two poses (4 x 4) are from each other."""
    return float(np.linalg.norm(one[:3, 3] - other[:3, 3]))


def turned(one: Matrix, other: Matrix) -> float:
    """Return by how much (rad) two poses (4 x 4) are turned against each other."""
    return float(Rotation.from_matrix(one[:3, :3].T @ other[:3, :3]).magnitude())


def numbers(pose: Matrix, angles: str = RPY) -> Six:
    """Return (x, y, z in m, three angles in rad); where the angles are not unique, the third is 0."""
    first, second, third = Rotation.from_matrix(pose[:3, :3]).as_euler(angles, suppress_warnings=True)
    x, y, z = pose[:3, 3]
    return float(x), float(y), float(z), float(first), float(second), float(third)
