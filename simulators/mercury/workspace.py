"""The arm's workspace: the sand, and the limits of all four joints along the whole motion.

A joint does not jump: the tool's world angle is counted beyond half a turn, so that the fourth joint follows it
without a step, and a motion on which it would pass its limit is refused.
"""

from math import isfinite
from typing import Any

from robots.kit.drivers.mercury.scara import OutOfReach, scara
from simulators.mercury.arm import Pose

SLACK_M = 1e-4
PARTS = 24  # steps of a straight line; no joint's path over the sand needs more
Joints = tuple[float, float, float, float]


class Workspace:
    """The arm's limits; every pose in m and rad."""

    def __init__(self, description: dict[str, Any]) -> None:
        self.arm = scara(description)
        self._sand = description["sand"]

    def joints(self, pose: Pose) -> Joints:
        """Return the joints of a pose (rad, m), the fourth with the whole turns of the pose. Raises OutOfReach."""
        branches = self.arm.branches(*pose.as_tuple())
        if not branches:
            raise OutOfReach("no branch of the elbow reaches that point")
        q1, q2, q3, _ = branches[0]
        return q1, q2, q3, pose.theta - q1 - q2 - self.arm.tool_angle

    def passed(self, pose: Pose) -> str | None:
        """Return a sentence that names a limit outside which the pose is, or None."""
        try:
            q1, q2, q3, q4 = self.joints(pose)
        except OutOfReach as error:
            return str(error)
        forgiven = [
            min(max(v, limit.low), limit.high) if limit.contains(v, SLACK_M) else v
            for v, limit in zip((q1, q2, q3, q4), (self.arm.q1, self.arm.q2, self.arm.q3, self.arm.q4), strict=True)
        ]
        return self.arm.broken_limit((forgiven[0], forgiven[1], forgiven[2], forgiven[3]))

    def line_end(self, start: Pose, x: float, y: float, z: float) -> Pose | None:
        """Return the end of a straight line from `start` to a point, with the same world angle; None if refused."""
        low, high = self.arm.q3.low, self.arm.q3.high
        inside = self._in("x", x) and self._in("y", y) and low - SLACK_M <= z <= high + SLACK_M
        if not inside:
            return None
        return self._way(start, Pose(x, y, min(max(z, low), high), start.theta))

    def turn_end(self, start: Pose, theta: float) -> Pose | None:
        """Return `start` with the tool turned to `theta`, counted in the direction of joint 4; None if refused."""
        try:
            q1, q2, _, q4 = self.arm.inverse(start.x, start.y, start.z, theta)
        except OutOfReach:
            return None
        return self._way(start, Pose(start.x, start.y, start.z, q1 + q2 + q4 + self.arm.tool_angle))

    def tidy_pose(self, pose: Pose) -> Pose | None:
        """Return the pose with its angle counted like joint 4; None if it is impossible."""
        if not all(isfinite(v) for v in pose.as_tuple()):
            return None
        turned = self.turn_end(pose, pose.theta)
        return turned and self.line_end(turned, turned.x, turned.y, turned.z)

    def _in(self, axis: str, value: float) -> bool:
        low, high = self._sand[axis]
        return bool(low - SLACK_M <= value <= high + SLACK_M)

    def _way(self, start: Pose, end: Pose) -> Pose | None:
        pairs = list(zip(start.as_tuple(), end.as_tuple(), strict=True))
        for i in range(1, PARTS + 1):
            if self.passed(Pose(*(a + (b - a) * i / PARTS for a, b in pairs))):
                return None
        return end
