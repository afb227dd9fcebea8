"""The arm's body: a set-point with a trapezoidal speed profile, and a tool that swings behind it.

The set-point moves on a straight line from pose to pose. The tool hangs on flexible links: a damped oscillator driven
by the set-point's acceleration, which is why section 6.6 has a stability check.
"""

from bisect import bisect_right
from collections import deque
from dataclasses import dataclass, field
from math import hypot, pi, sqrt
from operator import itemgetter
from typing import Any

STEP_S = 0.002
SWING_HZ = 6.0
DAMPING = 0.18
RAMP_S = 0.28  # time to reach full speed: a faster arm accelerates harder
BRAKE = 2.0  # a hold brakes so many times as hard as a motion ends: rest matters more than swing
AT_REST_M = 0.00008  # swing below which two pictures no longer differ by the threshold
STILL_M = 1e-9  # swing below which nothing is integrated


@dataclass
class Pose:
    """Tool pose in m and rad."""

    x: float
    y: float
    z: float
    theta: float

    def as_tuple(self) -> tuple[float, float, float, float]:
        """Return (x, y, z, theta)."""
        return self.x, self.y, self.z, self.theta

    @classmethod
    def read(cls, stored: Any) -> "Pose":
        """Return the pose of a state that was stored. Raises ValueError, TypeError, KeyError, OverflowError."""
        x, y, z, theta = map(float, stored["pose"])
        return cls(x, y, z, theta)


START = Pose(0.0, 0.42, 0.075, 0.0)  # of a new arm


@dataclass
class Line:
    """A straight motion from `start` to `end` with a trapezoid of `speed` (m/s)."""

    start: Pose
    end: Pose
    speed: float
    way: float = 0.0
    velocity: float = 0.0
    braking: bool = False
    length: float = field(init=False)

    def __post_init__(self) -> None:
        """Measure the distance; a pure turn counts 0.1 m per radian."""
        a, b = self.start, self.end
        flat = hypot(b.x - a.x, b.y - a.y, b.z - a.z)
        self.length = max(flat, 0.1 * abs(b.theta - a.theta))

    def advance(self, dt: float) -> tuple[float, bool]:
        """Move on by `dt`; return the acceleration along the line and whether it ended."""
        acceleration = self.speed / RAMP_S * (BRAKE if self.braking else 1.0)
        left = self.length - self.way
        stopping = self.velocity**2 / (2 * acceleration)
        before = self.velocity
        if self.braking or left <= stopping + self.velocity * dt:
            self.velocity = max(0.0, self.velocity - acceleration * dt)
        else:
            self.velocity = min(self.speed, self.velocity + acceleration * dt)
        self.way += (before + self.velocity) / 2 * dt
        ended = self.way >= self.length or (self.velocity == 0.0 and (self.braking or before > 0.0))
        if ended and not self.braking:
            self.way, self.velocity = self.length, 0.0
        return (self.velocity - before) / dt, ended

    def at(self) -> Pose:
        """Return the present set-point."""
        share = self.way / self.length if self.length else 1.0
        a, b = self.start, self.end
        return Pose(
            a.x + (b.x - a.x) * share,
            a.y + (b.y - a.y) * share,
            a.z + (b.z - a.z) * share,
            a.theta + (b.theta - a.theta) * share,
        )


class Body:
    """Set-point and swinging tool, advanced by fixed steps up to the requested time."""

    def __init__(self, pose: Pose, at: float) -> None:
        self.setpoint = pose
        self.line: Line | None = None
        self.swing = [0.0, 0.0]
        self.swing_velocity = [0.0, 0.0]
        self.time = at
        self.past: deque[tuple[float, float, float, float, float]] = deque(maxlen=400)
        self.last_line: Line | None = None

    @property
    def moving(self) -> bool:
        """Return whether the set-point's velocity is not zero."""
        return self.line is not None

    def amplitude(self) -> float:
        """Return the envelope of the swing (m)."""
        omega = 2 * pi * SWING_HZ
        return sqrt(sum(s * s + (v / omega) ** 2 for s, v in zip(self.swing, self.swing_velocity, strict=True)))

    def start(self, end: Pose, speed: float) -> None:
        """Start a motion to `end`."""
        self.line = Line(self.setpoint, end, speed)

    def brake(self) -> None:
        """Brake the set-point to rest."""
        if self.line is not None:
            self.line.braking = True

    def advance_to(self, at: float) -> None:
        """Integrate up to `at` (s, monotonic); at rest only the time changes."""
        if self.line is None and self.amplitude() < STILL_M:
            self.time = max(self.time, at)
            return
        if at - self.time > 0.5:  # the process was stopped; the physics went on
            self.time = at - 0.5
        while self.time + STEP_S <= at:
            self._step()
            self.time += STEP_S
            x, y, z, theta = self.setpoint.as_tuple()
            self.past.append((self.time, x + self.swing[0], y + self.swing[1], z, theta))

    def _step(self) -> None:
        push = (0.0, 0.0)
        if self.line is not None:
            line = self.line
            along, ended = line.advance(STEP_S)
            self.setpoint = line.at()
            span = line.length or 1.0
            dx = (line.end.x - line.start.x) / span
            dy = (line.end.y - line.start.y) / span
            dz = (line.end.z - line.start.z) / span
            push = (along * (dx + 0.15 * dz), along * (dy + 0.10 * dz))
            if ended:
                self.line, self.last_line = None, line
        omega = 2 * pi * SWING_HZ
        for i in (0, 1):
            pull = -2 * DAMPING * omega * self.swing_velocity[i] - omega**2 * self.swing[i]
            self.swing_velocity[i] += (pull - push[i]) * STEP_S
            self.swing[i] += self.swing_velocity[i] * STEP_S

    def during(self, since: float, until: float, count: int) -> list[tuple[float, float, float, float]]:
        """Return `count` tool poses spread evenly over an exposure from `since` to `until`; one if it rested."""
        past = list(self.past.copy())
        if not past:
            x, y, z, theta = self.setpoint.as_tuple()
            return [(x + self.swing[0], y + self.swing[1], z, theta)]
        instants = [since + (until - since) * i / max(1, count - 1) for i in range(count)]
        found = [past[max(0, bisect_right(past, at, key=itemgetter(0)) - 1)][1:] for at in instants]
        return found if len(set(found)) > 1 else found[:1]
