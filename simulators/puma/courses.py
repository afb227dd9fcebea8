"""Instructions on the wire as motions and velocities, and the motion by which the controller finds its zeros."""

from dataclasses import dataclass
from math import radians

import numpy as np

from robots.kit.arms.budget import MOST, Budget
from robots.kit.arms.chain import Joints
from robots.kit.arms.motions import Motion, MotionPlanner
from robots.kit.arms.path import Cubic, Path
from robots.kit.arms.planner import Refused, in_words
from robots.kit.drivers.puma.protocol import JOINTS, Instruction

INDEX_RAD = radians(3.0)  # from anywhere to the index pulse of an encoder, about
THERE_S = 1.1  # that the way to it takes, and the way back
LONGEST_S = 900.0
UP_AND_DOWN = [1, 2, 4]  # the joints that raise and lower a part of the arm
Numbers = tuple[int, ...]


@dataclass(frozen=True)
class OutAndBack:
    """A motion to `way` (rad, of each joint) from `start`, and back to it."""

    start: Joints
    way: Joints

    @property
    def seconds(self) -> float:
        """Return the motion time (s)."""
        return 2 * THERE_S

    def _halves(self) -> tuple[Cubic, Cubic]:
        still, there = np.zeros_like(self.start), self.start + self.way
        return Cubic.between(self.start, still, there, THERE_S), Cubic.between(there, still, self.start, THERE_S)

    def at(self, t: float) -> tuple[Joints, Joints, Joints]:
        """See `Path`."""
        out, back = self._halves()
        return out.at(t) if t < THERE_S else back.at(t - THERE_S)

    def sample(self, times: Joints) -> Joints:
        """See `Path`."""
        out, back = self._halves()
        return np.where((times < THERE_S)[:, None], out.sample(times), back.sample(times - THERE_S))

    def fastest(self) -> Joints:
        """See `Path`."""
        out, back = self._halves()
        return np.maximum(out.fastest(), back.fastest())


class Courses(MotionPlanner):
    """Plans the instructions of the wire."""

    def __init__(self) -> None:
        super().__init__("puma", LONGEST_S)

    def close(self) -> None:
        """Give back what plans need; there is nothing here."""

    def motion_path(self, motion: Motion, q: Joints) -> Path:
        """Return the path of a motion from rest at `q` (rad). Raises as `plan_motion`."""
        return self.plan_motion(motion, q, np.zeros_like(q)).path

    def index_path(self, q: Joints) -> Path:
        """Return a small motion of every joint from rest at `q` (rad), and back. Raises Refused."""
        limits, budget = self.planner.limits, Budget(MOST)
        first = np.where(q > (limits.low + limits.high) / 2, -1.0, 1.0)
        refusals = []
        for number in range(2 ** len(UP_AND_DOWN)):
            signs = first.copy()
            for place, joint in enumerate(UP_AND_DOWN):
                signs[joint] *= -1.0 if number >> place & 1 else 1.0
            try:
                return self._free(OutAndBack(q, INDEX_RAD * signs), budget)
            except Refused as error:
                refusals.append(error)
        raise refusals[0]

    def _free(self, path: OutAndBack, budget: Budget) -> Path:
        with in_words():
            self.planner.stand(path.start + path.way, path.start)
            touch = self.planner.widened_zones.swept(path, budget)
        if touch is not None:
            raise Refused("box", f"on the way there {touch[1]}")
        return path


def motion_of(what: int, numbers: Numbers) -> Motion:
    """Return the motion of JOINTS, POSE or LINE with these numbers, of which the first is the latest clock."""
    _, share, *six = numbers
    scale = share / 1000
    if what == Instruction.JOINTS:
        return Motion(tuple(radians(v / 1000) for v in six), scale=scale)
    x, y, z = (v / 100_000 for v in six[:3])
    yaw, pitch, roll = (radians(v / 1000) for v in six[3:])
    return Motion(pose=(x, y, z, roll, pitch, yaw), straight=what == Instruction.LINE, scale=scale)


def velocity_of(what: int, numbers: Numbers) -> Joints:
    """Return the velocities of a JOG_JOINTS (rad/s), or of the tool of a JOG_TOOL (m/s, rad/s)."""
    six = np.array(numbers[1:], dtype=np.float64)
    assert len(six) == JOINTS
    if what == Instruction.JOG_JOINTS:
        return np.radians(six / 1000)
    return np.append(six[:3] / 100_000, np.radians(six[3:] / 1000))
