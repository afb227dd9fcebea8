"""Inverse kinematics of a serial arm: every branch in closed form, the nearest is chosen.

The closed form is derived from the chain by EAIK (Ostermeier, Külz, Althoff 2025: subproblem
decomposition). It answers targets out of reach by least squares and flags some exact answers
at full stretch the same way, so an answer counts where forward kinematics agree, not by flag.
"""

from functools import cached_property

import numpy as np
from eaik.IK_HP import HPRobot
from scipy.spatial.transform import Rotation

from robots.motion.chain import Chain, Joints, Matrix

EXACT_M = 1e-9  # an answer is an answer where the hand is so near (m)
EXACT_RAD = 1e-9
SLACK_RAD = 1e-9
POLISH = 8
SAME = 1e-7  # a pose that joints have turned about is the same to so much (m and rad)
SINGULAR = 1e-4  # least singular value of the Jacobian, in m and rad


class OutOfReach(ValueError):
    """The pose cannot be reached; the message says what stands in the way."""


class Inverse:
    """All joint vectors for a pose of the chain's tool."""

    def __init__(self, chain: Chain) -> None:
        self.chain = chain

    @cached_property
    def _solver(self) -> HPRobot:
        frames = self.chain.frames(np.zeros(len(self.chain.joints)))
        axes = np.array([f[:3, :3] @ j.axis for f, j in zip(frames, self.chain.joints, strict=False)])
        points = np.array([f[:3, 3] for f in frames])
        solver = HPRobot(axes, np.diff(points, axis=0, prepend=np.zeros((1, 3))))
        if not solver.hasKnownDecomposition():
            raise ValueError("no closed form is known for a chain of this shape")
        return solver

    @cached_property
    def _upright(self) -> Matrix:
        """Return the tool's rotation with all joints at zero, which EAIK takes for none."""
        rotation: Matrix = self.chain.forward(np.zeros(len(self.chain.joints)))[:3, :3]
        return rotation

    def branches(self, pose: Matrix) -> list[Joints]:
        """Return every joint vector that puts the tool at `pose` (4 x 4), limits not looked at; each in (-pi, pi]."""
        found, _ = self._solve(pose)
        return found

    def _answers(self, pose: Matrix) -> tuple[Matrix, Matrix]:
        """Return the pose as EAIK wants it, and what it answers, exact or not, of shape (k, n)."""
        asked = pose.copy()
        asked[:3, :3] = pose[:3, :3] @ self._upright.T
        return asked, np.asarray(self._solver.IK(asked).Q, dtype=float).reshape(-1, len(self.chain.joints))

    def _solve(self, pose: Matrix) -> tuple[list[Joints], float]:
        asked, answers = self._answers(pose)
        turned = -((-answers + np.pi) % (2 * np.pi) - np.pi)
        off = np.array([self._solver.fwdKin(q) for q in turned]).reshape(-1, 4, 4) - asked
        miss = np.sqrt(np.sum(off[:, :3, 3] ** 2, axis=1))
        turn = np.sqrt(np.sum(off[:, :3, :3] ** 2, axis=(1, 2)))
        exact = turned[(miss < EXACT_M) & (turn < EXACT_RAD)]
        apart = np.max(np.abs(exact[:, None] - exact[None]), axis=2, initial=0.0)
        first = ~np.any(np.tril(apart < EXACT_RAD, -1), axis=1)  # each answer once
        return list(exact[first]), float(np.min(miss, initial=np.inf))

    def inside(self, pose: Matrix) -> list[Joints]:
        """Return the branches inside all limits, turned by whole turns into them where that is possible.

        Raises:
            OutOfReach: none is; says how far away, or which limit every branch breaks first.

        """
        found, nearest = self._solve(pose)
        if not found:
            raise OutOfReach(f"the hand would stay {nearest:.3f} m away: the arm is too short, or too long, for that")
        turned = self._into(np.array(found))
        outside = np.maximum(self.chain.low - turned, turned - self.chain.high)
        inside = turned[np.all(outside <= SLACK_RAD, axis=1)]
        if not len(inside):
            inside = np.array(self._singular(pose))
        if not len(inside):
            least = turned[np.argmin(np.sum(np.maximum(outside, 0.0), axis=1))]
            raise OutOfReach(self.chain.broken_limit(least))
        return list(inside)

    def nearest(self, pose: Matrix, near: Joints) -> Joints:
        """Return the branch whose slowest joint has the shortest way from `near`.

        Raises:
            OutOfReach: as `inside`.

        """
        inside = np.array(self.inside(pose))
        nearest: Joints = inside[np.argmin(np.max(np.abs(inside - near) / self.chain.velocity, axis=1))]
        return nearest

    def _singular(self, pose: Matrix) -> list[Joints]:
        """Return answers at singular poses, where the closed form gives one share of many, or only comes near."""
        _, near = self._answers(pose)
        polished = (self._polished(self._into(q), pose) for q in near)
        slid = (self._slid(q) for q in polished if q is not None)
        return [q for q in slid if q is not None]

    def _polished(self, q: Joints, pose: Matrix) -> Joints | None:
        """Return `q` brought onto the pose by a few steps of Gauss and Newton; None where it does not come there."""
        for _ in range(POLISH):
            here = self.chain.forward(q)
            turn = Rotation.from_matrix(pose[:3, :3] @ here[:3, :3].T).as_rotvec()
            off = np.concatenate([pose[:3, 3] - here[:3, 3], turn])
            if np.max(np.abs(off)) < EXACT_M:
                return q
            q = q + np.linalg.pinv(self.chain.jacobian(q), rcond=1e-6) @ off
        return None

    def _slid(self, q: Joints) -> Joints | None:
        """Return `q` moved into the limits where it is singular: joints that turn against each other stand anyhow.

        The closed form gives one share between them of many. None where no share is inside.
        """
        _, values, rows = np.linalg.svd(self.chain.jacobian(q))
        if values[-1] > SINGULAR:
            return None
        way, low, high = rows[-1], self.chain.low - q, self.chain.high - q
        turns = np.abs(way) > 1e-6
        if np.any(low[~turns] > SLACK_RAD) or np.any(high[~turns] < -SLACK_RAD):
            return None
        ends = np.sort(np.array([low[turns], high[turns]]) / way[turns], axis=0)
        first, last = float(np.max(ends[0])), float(np.min(ends[1]))
        if first > last + SLACK_RAD:
            return None
        slid = np.clip(q + way * min(max(0.0, first), last), self.chain.low, self.chain.high)
        off = self.chain.forward(slid) - self.chain.forward(q)
        same: bool = bool(np.max(np.abs(off)) < SAME)
        return slid if same else None

    def _into(self, q: Joints) -> Joints:
        low, high = self.chain.low, self.chain.high
        q = np.where((q < low) & (q + 2 * np.pi <= high + 1e-9), q + 2 * np.pi, q)
        return np.where((q > high) & (q - 2 * np.pi >= low - 1e-9), q - 2 * np.pi, q)


def singularity(chain: Chain, q: Joints, least: float = SINGULAR) -> str:
    """Return a sentence that names the joints between which motion is lost at `q`; empty where none is."""
    _, values, rows = np.linalg.svd(chain.jacobian(q))
    if values[-1] > least:
        return ""
    share = np.abs(rows[-1])
    names = [j.name for j, s in zip(chain.joints, share, strict=True) if s > 0.2 * share.max()]
    if len(names) == 1:
        return f"a singular pose: turning {names[0]} does not move the hand"
    return f"a singular pose: turning {', '.join(names[:-1])} and {names[-1]} against each other does not move the hand"
