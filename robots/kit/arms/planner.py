"""Plans a motion that is free of boxes: limits, kinematics, path, check against the boxes.

Pure. It is used when a command is accepted and again by the controller that runs it, so that refusals come early and
with the same words.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np

from robots.kit.arms.budget import MOST, MOTION, Budget, TooMuch
from robots.kit.arms.chain import Chain, Joints, Matrix
from robots.kit.arms.inverse import Inverse, OutOfReach
from robots.kit.arms.path import Limits, Path, TooFast, brake_path, joint_path
from robots.kit.arms.singular import singularity
from robots.kit.arms.straight import line_path
from robots.kit.arms.zones import Zones


class Refused(ValueError):
    """The motion is not planned; `code` is `range` for limits and reach, `box` for zones, otherwise `busy`."""

    def __init__(self, code: str, text: str) -> None:
        super().__init__(text)
        self.code = code


@contextmanager
def in_words() -> Iterator[None]:
    """Translate errors of the parts of a planner into a refusal. Raises Refused."""
    try:
        yield
    except (OutOfReach, TooMuch) as error:
        raise Refused("range", str(error)) from error
    except TooFast as error:
        raise Refused("busy", str(error)) from error


@dataclass(frozen=True)
class Plan:
    """A motion: its end (rad) and its path."""

    target: Joints
    path: Path


class Planner:
    """Plans motions of one arm among its boxes.

    `zones` are the boxes that the arm itself must not enter. Planned motions keep `clearance` (m) away from them,
    because an arm follows its reference with an error.
    """

    def __init__(self, chain: Chain, zones: Zones, limits: Limits, clearance: float = 0.0) -> None:
        self.chain, self.zones, self.limits = chain, zones, limits
        self.widened_zones = zones.widened(clearance)
        self.inverse = Inverse(chain)

    def reach(self, pose: Matrix, near: Joints, budget: Budget | None = None) -> Joints:
        """Return the joints for a pose (4 x 4), the answer nearest to `near`. Raises Refused."""
        with in_words():
            return self.inverse.nearest(pose, near, budget or Budget(MOST))

    def stand(self, target: Joints, q: Joints | None = None) -> None:
        """Refuse joints at which the arm must not rest; an arm inside a box at `q` may rest less deep inside."""
        broken = self.chain.broken_limit(target)
        if broken:
            raise Refused("range", broken)
        if self.widened_zones.clear(target):
            return
        if q is None:
            distances = self.widened_zones.distances(target)
            floor = np.zeros_like(distances)
        else:
            distances, here = self.widened_zones.distances(np.array([target, q]))
            floor = self.widened_zones.floor(here)
        touch = self.widened_zones.entered(distances, floor)
        if touch is not None:
            raise Refused("box", f"there the {touch.limb} would enter {touch.box}")

    def joints(self, target: Joints, q: Joints, v: Joints, scale: float, budget: Budget | None = None) -> Plan:
        """Return the joint motion from the sampled position (rad) and velocity (rad/s).

        Raises:
            Refused: names the joint, or the limb and the box.
        """
        budget = budget or Budget(MOST)
        with in_words():
            budget.spend(MOTION)
            self.stand(target, q)
            return self._swept(Plan(target, joint_path(q, v, target, self.limits, scale)), budget)

    def line(self, pose: Matrix, q: Joints, v: Joints, scale: float, budget: Budget | None = None) -> Plan:
        """Return the straight motion of the tool from rest. Raises Refused."""
        if np.any(np.abs(v) > 1e-6):
            raise Refused("busy", "a straight line begins at rest: hold the arm first")
        budget = budget or Budget(MOST)
        with in_words():
            budget.spend(MOTION)
            path = line_path(self.inverse, q, pose, self.limits, scale, budget)
            target = path.q[-1]
            self.stand(target, q)
            return self._swept(Plan(target, path), budget)

    def _swept(self, plan: Plan, budget: Budget) -> Plan:
        found = self.widened_zones.swept(plan.path, budget)
        if found is not None:
            raise Refused("box", f"on the way there, after {found[0]:.1f} s, {found[1]}")
        return plan

    def brake(self, q: Joints, v: Joints) -> Path:
        """Return the hardest path to rest."""
        return brake_path(q, v, self.limits)

    def tool_velocity(self, q: Joints, twist: Joints) -> Joints:
        """Return joint velocities (rad/s) for a twist of the tool (m/s, rad/s), damped near singular poses."""
        jacobian = self.chain.jacobian(q)
        damping = 0.02 if singularity(self.chain, q, 0.05) else 1e-4
        damped = jacobian @ jacobian.T + damping**2 * np.eye(6)
        return np.asarray(jacobian.T @ np.linalg.solve(damped, twist))
