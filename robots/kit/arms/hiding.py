"""What hides an object from a camera: the arm in its posture, and other objects. Pure; lengths in m, poses 4 x 4."""

from collections.abc import Iterable

import numpy as np

from robots.kit.arms import segments
from robots.kit.arms.chain import Chain, Joints, Matrix
from robots.kit.arms.objects import ObjectTable
from robots.kit.arms.solids import Solid
from robots.kit.arms.zones import Limb

OFF_M = 0.001  # from a point on a surface to where its way to the camera begins


class Hiding:
    """Boxes around the limbs of an arm; those of the gripper, which its last joint moves, are the table's `hand`."""

    def __init__(self, chain: Chain, limbs: Iterable[Limb], table: ObjectTable) -> None:
        self._chain, last = chain, len(chain.joints) - 1
        self._limbs = [(limb.joint, *_around(limb)) for limb in limbs if limb.joint != last]
        self._hand = [tuple(map(np.array, corners)) for corners in table.hand]

    def hides(self, q: Joints, others: Iterable[Solid], seat: Matrix, points: Matrix) -> bool:
        """Return whether a camera at `seat` (3,) does not see all of the points (n, 3), the arm's joints being `q`."""
        ways = seat - points
        ends = points + OFF_M * ways / np.linalg.norm(ways, axis=1, keepdims=True)
        frames = self._chain.frames(q)
        tool = self._chain.forward(q)
        boxes = [(frames[joint], low, high) for joint, low, high in self._limbs]
        boxes += [(tool, low, high) for low, high in self._hand]
        boxes += [(one.pose, -np.array(one.half), np.array(one.half)) for one in others]
        return any(_crosses(pose, low, high, seat, ends) for pose, low, high in boxes)


def _around(limb: Limb) -> tuple[Matrix, Matrix]:
    begin, end = np.array(limb.begin), np.array(limb.end)
    return np.minimum(begin, end) - limb.radius, np.maximum(begin, end) + limb.radius


def _crosses(pose: Matrix, low: Matrix, high: Matrix, seat: Matrix, ends: Matrix) -> bool:
    turn, place = pose[:3, :3], pose[:3, 3]
    begin = np.broadcast_to((seat - place) @ turn, ends.shape)
    found = segments.exactly(begin, (ends - place) @ turn, low, high)
    return bool((found <= 0.0).any())
