"""The set-point that the controller follows: along a path, by velocities, or at rest.

It has no lock and no clock: its owner calls it under one lock, and `now` is the control loop's time in s. Angles in
rad, velocities in rad/s.
"""

from dataclasses import dataclass

import numpy as np

from robots.kit.arms.chain import Joints
from robots.kit.arms.path import Path
from robots.kit.arms.planner import Planner, Refused
from simulators.common.arm.scene import STEP_S

STILL = 1e-9
LOOK_S = 0.01  # between two checks ahead


@dataclass(frozen=True)
class Reference:
    """The reference of the controller: rad, rad/s, rad/s2; gripper 0 open, 1 closed."""

    q: Joints
    v: Joints
    a: Joints
    gripper: int


class VelocityCommand:
    """Velocities of the joints (rad/s), or with `tool` those of the tool (m/s, rad/s); they last `dead_man_s`.

    Times are the control loop's, in s.
    """

    def __init__(self, tool: bool, values: Joints, now: float, dead_man_s: float) -> None:
        self._tool, self._values, self._dead_man_s = tool, values, dead_man_s
        self.until = now + dead_man_s
        self._free_until = 0.0  # the path was found free until then

    def again(self, tool: bool, values: Joints, now: float) -> None:
        """Note that the command was repeated or changed."""
        if tool != self._tool or np.any(values != self._values):
            self.look_again()
        self._tool, self._values, self.until = tool, values, now + self._dead_man_s

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
        wanted = planner.tool_velocity(q, self._values) if self._tool else self._values
        wanted = wanted / max(1.0, float(np.max(np.abs(wanted) / planner.limits.velocity)))
        if now >= self._free_until:
            self._free_until = now + LOOK_S if _may_go_on(planner, q, v, wanted) else 0.0
        return wanted if self._free_until else np.zeros_like(v)


def _may_go_on(planner: Planner, q: Joints, v: Joints, wanted: Joints) -> bool:
    """Return whether the arm could still brake in time after one more step at the wanted speed."""
    limits, kept = planner.limits, planner.widened_zones
    faster = np.where(np.abs(wanted) > np.abs(v), wanted, v)
    stop = q + faster * 2 * LOOK_S + faster * np.abs(faster) / (2 * limits.acceleration)
    if np.any((stop < limits.low) & (faster < 0)) or np.any((stop > limits.high) & (faster > 0)):
        return False
    floor = kept.floor(kept.distances(q))
    ahead = (q + share * (stop - q) for share in (0.5, 1.0))
    return not any(kept.entered(kept.distances(one), floor) for one in ahead)


class SetPoint:
    """The present reference, and the source of its motion.

    `dead_man_s`: a velocity ends unless it is repeated within that time.
    """

    def __init__(self, planner: Planner, q: Joints, dead_man_s: float) -> None:
        self.planner, self._dead_man_s = planner, dead_man_s
        self.q, self.v, self.a = q.copy(), np.zeros_like(q), np.zeros_like(q)
        self._path: Path | None = None
        self._began = 0.0
        self._next: tuple[float, Path] | None = None  # when a blend takes over
        self._velocity: VelocityCommand | None = None

    @property
    def moving(self) -> bool:
        """Return whether it moves, or will in a moment."""
        return self.on_path or self._velocity is not None

    @property
    def on_path(self) -> bool:
        """Return whether a path is followed or waits for its start."""
        return self._path is not None or self._next is not None

    @property
    def in_motion(self) -> bool:
        """Return whether a new path must start from a motion."""
        return self._path is not None or self.has_speed

    @property
    def has_speed(self) -> bool:
        """Return whether it moves at this moment."""
        return bool(np.any(np.abs(self.v) > STILL))

    def follows(self) -> object:
        """Return what is followed now; another object later means that the arm went another way."""
        return self._path if self._path is not None else self._velocity

    def ahead(self, at: float) -> tuple[Joints, Joints]:
        """Return position and velocity at the time `at` (s). Raises Refused while velocities drive it."""
        if self._path is not None:
            q, v, _ = self._path.at(at - self._began)
            return q, v
        if self.has_speed:
            raise Refused("busy", "the arm is driven by velocities; let it come to rest first")
        return self.q.copy(), self.v.copy()

    def take(self, path: Path, at: float) -> None:
        """Follow a path from the time `at` on."""
        self._next = (at, path)

    def drive(self, tool: bool, values: Joints, now: float) -> bool:
        """Drive by velocities for a moment, see `VelocityCommand`; return whether this starts the motion."""
        begins = self._velocity is None
        if self._velocity is None:
            self._velocity = VelocityCommand(tool, values, now, self._dead_man_s)
        else:
            self._velocity.again(tool, values, now)
        return begins

    def look_again(self) -> None:
        """Check the next velocity step again, because the boxes have changed."""
        if self._velocity is not None:
            self._velocity.look_again()

    def brake(self, now: float) -> None:
        """Come to rest with the hardest braking."""
        self._velocity = self._next = None
        if self.has_speed:
            self._path, self._began = self.planner.brake(self.q, self.v), now
        else:
            self._path = None
            self._still()  # also without the acceleration with which a path begins

    def stand(self, q: Joints) -> None:
        """Rest here."""
        self._velocity = self._next = self._path = None
        self.q = q.copy()
        self._still()

    def _still(self) -> None:
        self.v, self.a = np.zeros_like(self.q), np.zeros_like(self.q)

    def step(self, now: float) -> bool:
        """Advance to the time `now`; return whether it has just come to rest."""
        if self._next is not None and now >= self._next[0]:
            (self._began, self._path), self._next, self._velocity = self._next, None, None
        if self._path is not None:
            t = now - self._began
            self.q, self.v, self.a = self._path.at(t)
            if t >= self._path.seconds and self._next is None:
                self._path = None
                self._still()
                return True
        elif self._velocity is not None:
            self.q, self.v, self.a = self._velocity.follow(self.planner, self.q, self.v, now)
            if now >= self._velocity.until and not self.has_speed:
                self._velocity = None
                self._still()
                return True
        return False
