"""The tool follows a hand: velocities towards the newest place of a held command, limited in speed. Pure.

The hand's place is told from where it took the tool, so nobody has to know where either is, and to take it again makes
no jump. The velocity is proportional to what is missing, so the tool slows down before it is there (a proportional
controller, Craig 1986, section 9.3). A hand that jumps is lost: a tracker that loses sight of it tells places where no
hand has come.
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from robots.kit.arms.chain import Joints, Matrix
from robots.kit.contract.errors import MotionHeld
from robots.kit.contract.spec import Argument
from robots.kit.contract.values import number

WAY, TURN = ("dx", "dy", "dz"), ("rx", "ry", "rz")  # m along, and a rotation vector (rad) about, x y z of the base
HAND = (*(Argument(name, "m", -1.0, 1.0) for name in WAY), *(Argument(name, "rad", -3.2, 3.2) for name in TURN))
GRIP = Argument("closed", "", 0.0, 1.0, required=False, share="closed")  # the gripper: not told, it stays as it is
JUMP_M, JUMP_RAD = 0.1, 0.8  # between two places of the hand; it does not come so far in the time of a keep-alive
GAIN = 3.0  # 1/s; with a state a tenth of a second old it does not overshoot
THERE_M, THERE_RAD = 2e-4, 5e-4  # nearer it rests


class HandLost(MotionHeld):
    """The hand has jumped."""


@dataclass
class Follower:
    """Follows one hand from the tool's pose `begin` (4 x 4) on; the tool's greatest speed is told in m/s and rad/s."""

    begin: Matrix
    fastest_m_s: float
    fastest_rad_s: float
    _last: tuple[Joints, Rotation] = field(default=(np.zeros(3), Rotation.identity()), init=False)
    _closed: bool | None = field(default=None, init=False)  # what the gripper was told last

    def grip(self, hand: dict[str, Any]) -> bool | None:
        """Return whether the gripper shall close now; None while it is told nothing new. Raises BadRequest."""
        closed = number(hand, GRIP.name) >= 0.5 if GRIP.name in hand else None
        if closed is None or closed == self._closed:
            return None
        self._closed = closed
        return closed

    def twist(self, tool: Matrix, hand: dict[str, Any]) -> Joints:
        """Return the velocity of the tool (m/s along x y z, rad/s about x y z of the base) from its pose (4 x 4).

        `hand` has the values of `HAND`. Raises HandLost; BadRequest for values that are no numbers.
        """
        way = np.array([number(hand, name) for name in WAY])
        turn = Rotation.from_rotvec([number(hand, name) for name in TURN])
        before, turned = self._last
        jump, spun = float(np.linalg.norm(way - before)), float((turn * turned.inv()).magnitude())
        if jump > JUMP_M or spun > JUMP_RAD:
            raise HandLost(
                f"The hand jumped by {1000 * jump:.0f} mm and {np.degrees(spun):.0f}°, so the arm was held. "
                "Take the tool again."
            )
        self._last = way, turn
        missing = self.begin[:3, 3] + way - tool[:3, 3]
        rest = turn * Rotation.from_matrix(self.begin[:3, :3]) * Rotation.from_matrix(tool[:3, :3]).inv()
        along, about = (missing, THERE_M, self.fastest_m_s), (rest.as_rotvec(), THERE_RAD, self.fastest_rad_s)
        return np.concatenate([_limited(*along), _limited(*about)])


def _limited(missing: Joints, there: float, fastest: float) -> Joints:
    """Return the velocity for what is missing, zero if that is nearer than `there`."""
    length = float(np.linalg.norm(missing))
    if length <= there:
        return np.zeros_like(missing)
    return missing * (min(GAIN * length, fastest) / length)
