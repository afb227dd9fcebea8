"""Driving by velocities (`J`, `C`): as requested, but slow enough to brake before a limit or a box."""

import numpy as np

from robots.kit.arms.chain import Joints
from robots.kit.arms.planner import Planner
from simulators.pa10.scene import STEP_S

DEAD_MAN_S = 0.25
LOOK_S = 0.01  # between two checks ahead


class VelocityCommand:
    """One command, which lasts while it is repeated; times are the control loop's, in s."""

    def __init__(self, letter: str, values: Joints, now: float) -> None:
        self._letter, self._values, self.until = letter, values, now + DEAD_MAN_S
        self._free_until = 0.0  # the path was found free until then

    def again(self, letter: str, values: Joints, now: float) -> None:
        """Note that the command was repeated or changed."""
        if letter != self._letter or np.any(values != self._values):
            self.look_again()
        self._letter, self._values, self.until = letter, values, now + DEAD_MAN_S

    def look_again(self) -> None:
        """Check ahead in the next step, whatever was found before."""
        self._free_until = 0.0

    def follow(self, planner: Planner, q: Joints, v: Joints, now: float) -> tuple[Joints, Joints, Joints]:
        """Return position, velocity and acceleration one step later."""
        most = planner.limits.acceleration * STEP_S
        change = np.clip(self._wanted(planner, q, v, now) - v, -most, most)
        v = v + change
        return q + v * STEP_S, v, change / STEP_S

    def _wanted(self, planner: Planner, q: Joints, v: Joints, now: float) -> Joints:
        if now >= self.until:
            return np.zeros_like(v)
        wanted = self._values if self._letter == "J" else planner.tool_velocity(q, self._values)
        wanted = wanted / max(1.0, float(np.max(np.abs(wanted) / planner.limits.velocity)))
        if now >= self._free_until:
            self._free_until = now + LOOK_S if may_go_on(planner, q, v, wanted) else 0.0
        return wanted if self._free_until else np.zeros_like(v)


def may_go_on(planner: Planner, q: Joints, v: Joints, wanted: Joints) -> bool:
    """Return whether the arm could still brake in time after one more step at the wanted speed."""
    limits, kept = planner.limits, planner.widened_zones
    faster = np.where(np.abs(wanted) > np.abs(v), wanted, v)
    stop = q + faster * 2 * LOOK_S + faster * np.abs(faster) / (2 * limits.acceleration)
    if np.any((stop < limits.low) & (faster < 0)) or np.any((stop > limits.high) & (faster > 0)):
        return False
    floor = kept.floor(kept.distances(q))
    ahead = (q + share * (stop - q) for share in (0.5, 1.0))
    return not any(kept.entered(kept.distances(one), floor) for one in ahead)
