"""From a wish to a motion that is known to be free: limits, kinematics, path, sweep.

Pure, and used at both ends: by whoever accepts a command and by the controller that carries it
out, so that what is refused is refused early and in the same words.
"""

from dataclasses import dataclass

import numpy as np

from robots.motion.chain import Chain, Joints, Matrix
from robots.motion.inverse import Inverse, OutOfReach
from robots.motion.path import Limits, Path, TooFast, brake_path, joint_path, line_path
from robots.motion.singular import singularity
from robots.motion.zones import Zones


class Refused(ValueError):
    """The motion is not made; `code` is `range` for limits and reach, `box` for zones, `busy` else."""

    def __init__(self, code: str, text: str) -> None:
        super().__init__(text)
        self.code = code


@dataclass(frozen=True)
class Plan:
    """A motion: where it ends (rad) and how it goes."""

    target: Joints
    path: Path


class Planner:
    """What one arm may do among its boxes.

    `zones` are what the arm itself must not enter. What is planned keeps `clearance` (m) away
    from them, because an arm follows its reference with an error.
    """

    def __init__(self, chain: Chain, zones: Zones, limits: Limits, clearance: float = 0.0) -> None:
        self.chain, self.zones, self.limits = chain, zones, limits
        self.kept = zones.widened(clearance)
        self.inverse = Inverse(chain)

    def reach(self, pose: Matrix, near: Joints) -> Joints:
        """Return the joints for a pose (4 x 4), the branch nearest to `near`. Raises Refused."""
        try:
            return self.inverse.nearest(pose, near)
        except OutOfReach as error:
            raise Refused("range", str(error)) from error

    def stand(self, target: Joints, q: Joints | None = None) -> None:
        """Refuse joints at which the arm must not stand; coming from inside a box at `q` it may be less deep."""
        broken = self.chain.broken_limit(target)
        if broken:
            raise Refused("range", broken)
        distances = self.kept.distances(target)
        floor = np.zeros_like(distances) if q is None else self.kept.floor(self.kept.distances(q))
        touch = self.kept.entered(distances, floor)
        if touch is not None:
            raise Refused("box", f"there {touch}")

    def joints(self, target: Joints, q: Joints, v: Joints, scale: float) -> Plan:
        """Return the joint motion from the sampled position (rad) and velocity (rad/s).

        Raises:
            Refused: says which joint, or which limb would enter which box.

        """
        self.stand(target, q)
        try:
            path = joint_path(q, v, target, self.limits, scale)
        except TooFast as error:
            raise Refused("busy", str(error)) from error
        return self._swept(Plan(target, path))

    def line(self, pose: Matrix, q: Joints, v: Joints, scale: float) -> Plan:
        """Return the straight motion of the hand from rest. Raises Refused."""
        if np.any(np.abs(v) > 1e-6):
            raise Refused("busy", "a straight line begins at rest: hold the arm first")
        try:
            path = line_path(self.inverse, q, pose, self.limits, scale)
        except OutOfReach as error:
            raise Refused("range", str(error)) from error
        target = path.at(path.seconds)[0]
        self.stand(target, q)
        return self._swept(Plan(target, path))

    def _swept(self, plan: Plan) -> Plan:
        found = self.kept.swept(plan.path)
        if found is not None:
            raise Refused("box", f"on the way there, after {found[0]:.1f} s, {found[1]}")
        return plan

    def brake(self, q: Joints, v: Joints) -> Path:
        """Return the hardest way to rest."""
        return brake_path(q, v, self.limits)

    def hand_velocity(self, q: Joints, twist: Joints) -> Joints:
        """Return joint velocities (rad/s) for a twist of the hand (m/s, rad/s), damped near singular poses."""
        jacobian = self.chain.jacobian(q)
        damping = 0.02 if singularity(self.chain, q, 0.05) else 1e-4
        damped = jacobian @ jacobian.T + damping**2 * np.eye(6)
        return np.asarray(jacobian.T @ np.linalg.solve(damped, twist))
