"""Forward and inverse kinematics of a four-axis SCARA arm.

Two revolute joints in the horizontal plane, a vertical slide and a wrist roll. Closed
form, so the whole solution is a handful of lines and needs no general solver; the
lengths and limits come from the robot's description.

Joint vector: (q1 rad, q2 rad, q3 m, q4 rad). Pose: (x m, y m, z m, theta rad), theta
the orientation of the tool about the vertical in the frame of the base.
"""

from dataclasses import dataclass
from math import acos, atan2, cos, hypot, pi, radians, sin
from typing import Any


class OutOfReach(ValueError):
    """The pose cannot be reached; the message names the axis, the value and the limit."""


@dataclass(frozen=True)
class Limits:
    """An inclusive interval, in the unit of its joint."""

    low: float
    high: float

    def contains(self, value: float, slack: float = 1e-9) -> bool:
        """Return whether `value` lies inside, with a tolerance of `slack`."""
        return self.low - slack <= value <= self.high + slack


@dataclass(frozen=True)
class Scara:
    """The arm: link lengths (m), joint limits, angle of the tool on the wrist (rad)."""

    link1: float
    link2: float
    q1: Limits
    q2: Limits
    q3: Limits
    q4: Limits
    tool_angle: float = 0.0

    @property
    def outer_radius(self) -> float:
        """Return the greatest reach (m)."""
        return self.link1 + self.link2

    @property
    def inner_radius(self) -> float:
        """Return the least reach (m), which follows from the elbow's limit."""
        bend = min(pi, max(abs(self.q2.low), abs(self.q2.high)))
        return hypot(self.link1 + self.link2 * cos(bend), self.link2 * sin(bend))

    def forward(self, q: tuple[float, float, float, float]) -> tuple[float, float, float, float]:
        """Return the pose (x, y, z, theta) in m and rad of joints `q`."""
        q1, q2, q3, q4 = q
        x = self.link1 * cos(q1) + self.link2 * cos(q1 + q2)
        y = self.link1 * sin(q1) + self.link2 * sin(q1 + q2)
        return x, y, q3, wrap(q1 + q2 + q4 + self.tool_angle)

    def elbow(self, q: tuple[float, float, float, float]) -> tuple[float, float]:
        """Return the position of the elbow (x, y) in m, for drawing."""
        return self.link1 * cos(q[0]), self.link1 * sin(q[0])

    def branches(self, x: float, y: float, z: float, theta: float) -> list[tuple[float, float, float, float]]:
        """Return the elbow branches (none, one or two), without regard to joint limits.

        A point on the edge of the annulus has one; the closed form follows from the law of cosines.
        """
        r = hypot(x, y)
        c2 = (r * r - self.link1**2 - self.link2**2) / (2 * self.link1 * self.link2)
        if abs(c2) > 1 + 1e-12:
            return []
        bend = acos(max(-1.0, min(1.0, c2)))
        found = []
        for q2 in (bend, -bend) if bend > 1e-9 and bend < pi - 1e-9 else (bend,):
            q1 = atan2(y, x) - atan2(self.link2 * sin(q2), self.link1 + self.link2 * cos(q2))
            q1 = _into(q1, self.q1)
            found.append((q1, q2, z, _into(wrap(theta - q1 - q2 - self.tool_angle), self.q4)))
        return found

    def inverse(
        self,
        x: float,
        y: float,
        z: float,
        theta: float,
        near: tuple[float, float, float, float] | None = None,
    ) -> tuple[float, float, float, float]:
        """Return the joints for a pose, inside all limits, the branch nearest to `near`.

        Raises:
            OutOfReach: naming the first limit that every branch breaks.

        """
        found = self.branches(x, y, z, theta)
        if not found:
            raise OutOfReach(
                f"radius {hypot(x, y):.3f} m is outside the reach of "
                f"{self.inner_radius:.3f} to {self.outer_radius:.3f} m"
            )
        inside = [q for q in found if self.broken_limit(q) is None]
        if not inside:
            raise OutOfReach(str(self.broken_limit(found[0])))
        if near is None:
            return inside[0]
        return min(inside, key=lambda q: sum(abs(a - b) for a, b in zip(q, near, strict=True)))

    def broken_limit(self, q: tuple[float, float, float, float]) -> str | None:
        """Return a sentence naming the first joint outside its limits, or None."""
        named = (("q1", "rad"), ("q2", "rad"), ("q3", "m"), ("q4", "rad"))
        for (name, unit), limit, value in zip(named, (self.q1, self.q2, self.q3, self.q4), q, strict=True):
            if not limit.contains(value):
                return f"joint {name} would be {value:.3f} {unit}, outside {limit.low:.3f} to {limit.high:.3f} {unit}"
        return None


def wrap(angle: float) -> float:
    """Return `angle` (rad) in (-pi, pi]."""
    return -((-angle + pi) % (2 * pi) - pi)


def _into(angle: float, limit: Limits) -> float:
    """Return `angle` turned by whole turns into `limit` if possible."""
    for turned in (angle, angle + 2 * pi, angle - 2 * pi):
        if limit.contains(turned):
            return turned
    return angle


def scara(description: dict[str, Any]) -> Scara:
    """Return the arm's kinematics from `[arm]` of its description (SI units)."""
    arm = description["arm"]
    return Scara(
        link1=arm["link1"],
        link2=arm["link2"],
        q1=Limits(*map(radians, arm["q1_deg"])),
        q2=Limits(*map(radians, arm["q2_deg"])),
        q3=Limits(*arm["q3"]),
        q4=Limits(*map(radians, arm["q4_deg"])),
        tool_angle=radians(arm["tool_angle_deg"]),
    )
