"""Inverse kinematics of a serial arm: every branch in closed form; the nearest is chosen.

The closed form is derived from the chain by EAIK (Ostermeier, Külz, Althoff 2025: subproblem decomposition). EAIK
answers targets out of reach by least squares, and marks some exact answers at full stretch in the same way. So an
answer counts if forward kinematics agrees, whatever its mark. A joint whose range is more than one turn gives several
answers for one branch. Branches often differ only in joints that are not the slowest: then those joints decide, and not
the order of EAIK, so that the browser (frontend/src/motion/inverse.ts) chooses the same.
"""

from collections.abc import Iterator
from functools import cached_property
from itertools import product
from math import ceil, hypot, inf, isfinite, remainder, tau
from operator import sub
from typing import NoReturn

import numpy as np
from eaik.IK_HP import HPRobot

from robots.kit.arms import singular
from robots.kit.arms.budget import SHARED, Budget
from robots.kit.arms.chain import Chain, Joints, Matrix
from robots.kit.arms.singular import EVEN_S

EXACT = 1e-9  # an answer counts if no number of its pose differs by more (m, or of a rotation)
SAME_POSE = 2e-6  # m, or of a rotation: the tool is there already, as a pose is told with five decimals of a degree
AT_ONCE_S, NEAR_S = 1e-6, 0.05  # an answer no farther than this (s at full speed) is the nearest, or as good as it
FAR_S = 0.5  # up to this an answer is as good as the nearest if EAIK marks no branch of the pose as singular
SAME_RAD = 1e-9
ALIKE_RAD = 1e-6  # angles that differ by less are the same in a refusal
BESIDE = 0.01  # see `singular.polished`
SLACK_RAD = 1e-9
CLOSE_M = 1e-3  # a larger error is not just lost precision at a singular pose


class OutOfReach(ValueError):
    """The pose cannot be reached; the message says what stands in the way."""


class Inverse:
    """All joint vectors for a pose of the chain's tool."""

    def __init__(self, chain: Chain) -> None:
        self.chain = chain
        self._low = [j.low - SLACK_RAD for j in chain.joints]
        self._high = [j.high + SLACK_RAD for j in chain.joints]
        self._limits = [(j.low - SLACK_RAD, j.high + SLACK_RAD, 1.0 / j.velocity) for j in chain.joints]
        offsets = [j.origin[:3, 3] for j in chain.joints]
        self._longest = float(sum(np.linalg.norm(way) for way in (*offsets, chain.tool[:3, 3])))

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
    def _upright(self) -> Matrix | None:
        """Return the tool's rotation with all joints at zero, which EAIK assumes to be none; None if it is none."""
        rotation: Matrix = self.chain.forward(np.zeros(len(self.chain.joints)))[:3, :3]
        return None if np.array_equal(rotation, np.eye(3)) else rotation

    def _asked(self, pose: Matrix) -> tuple[Matrix, list[float]]:
        """Return the pose for EAIK, and its 16 numbers. Raises OutOfReach for a pose far from the arm."""
        asked = pose
        if self._upright is not None:
            asked = pose.copy()
            asked[:3, :3] = pose[:3, :3] @ self._upright.T
        values: list[float] = asked.ravel().tolist()
        far = hypot(values[3], values[7], values[11])
        if not far <= 2 * self._longest or not isfinite(sum(values)):
            where = f"{far:.3g} m from the base" if isfinite(far) else "not a position"
            raise OutOfReach(f"that is {where}: the arm reaches {self._longest:.2f} m at most")
        return asked, values

    def nearest(self, pose: Matrix, near: Joints, budget: Budget | None = None) -> Joints:
        """Return the answer whose slowest joint has the shortest way from `near`, over all branches and whole turns.

        Of equally near answers it is the one whose other joints move less. At a singular pose, over all shares of the
        joints that turn against each other, too. If the tool is at the pose already, that is `near` itself.

        Raises:
            OutOfReach: as `inside`. TooMuch: more singular poses than the budget allows.

        """
        asked, values = self._asked(pose)
        start: list[float] = near.tolist()
        solved = self._solver.IK(asked)
        answers: list[list[float]] = solved.Q.tolist()
        best, least, squares = None, inf, inf
        for answer in answers:
            turned = self._turned(answer, start, least + EVEN_S)
            if turned is not None and (turned[0] < least - EVEN_S or turned[1] < squares):
                least, squares, best = turned
        exact = best is not None and self._exact(best, values)
        if best is not None and exact and least <= AT_ONCE_S:
            return np.array(best)
        if self._exact(start, values, SAME_POSE) and not self.chain.broken_limit(near):
            return np.array(start)
        if best is not None and exact and (least <= NEAR_S or (least <= FAR_S and 1 not in solved.is_LS.tolist())):
            return np.array(best)
        every = [best] if best is not None and exact else self._inside(answers, start, values)
        found = singular.nearest_of(self.chain, [*map(np.array, every), *self._shared(pose, near, budget)], near)
        if found is None:
            self._refuse(pose)
        return found

    def _inside(self, answers: list[list[float]], start: list[float], values: list[float]) -> Iterator[list[float]]:
        """Yield the exact answers inside the limits, each in the turns nearest to `start`."""
        for answer in answers:
            turned = self._turned(answer, start, inf)
            if turned is not None and self._exact(turned[2], values):
                yield turned[2]

    def _turned(self, answer: list[float], start: list[float], bound: float) -> tuple[float, float, list[float]] | None:
        """Return cost (s at full speed), squares of all joints' times and joints, in the nearest turns inside limits.

        None if there are none inside, or the cost is above `bound`.
        """
        cost, squares, found = 0.0, 0.0, []
        for value, here, (low, high, pace) in zip(answer, start, self._limits):  # noqa: B905 - all of them are n long
            turned = here + remainder(value - here, tau)
            if turned < low:
                turned += tau * ceil((low - turned) / tau)
            elif turned > high:
                turned -= tau * ceil((turned - high) / tau)
            way = abs(turned - here) * pace
            if way > cost:
                cost = way
            if cost > bound or not low <= turned <= high:
                return None
            squares += way * way
            found.append(turned)
        return cost, squares, found

    def _exact(self, q: list[float], values: list[float], within: float = EXACT) -> bool:
        """Return whether joints put the tool at the pose with the 16 numbers `values`."""
        found = self._solver.fwdKin(q)
        if abs(found.item(3) - values[3]) >= within:  # one number first, because most are elsewhere
            return False
        there: list[float] = found.ravel().tolist()
        return bool(max(map(abs, map(sub, there, values))) < within)

    def branches(self, pose: Matrix) -> list[Joints]:
        """Return every joint vector that puts the tool at `pose` (4 x 4), without limits; each in (-pi, pi].

        Raises:
            OutOfReach: the pose is far from the arm.
        """
        found, _ = self._solve(pose)
        return found

    def _solve(self, pose: Matrix) -> tuple[list[Joints], Matrix]:
        """Return the branches, each once, and the error in m of all answers of EAIK."""
        asked, _ = self._asked(pose)
        answers = np.asarray(self._solver.IK(asked).Q, dtype=float).reshape(-1, len(self.chain.joints))
        turned = -((-answers + np.pi) % (2 * np.pi) - np.pi)
        off = np.array([self._solver.fwdKin(q) for q in turned]).reshape(-1, 4, 4) - asked
        exact = turned[np.abs(off).max(axis=(1, 2), initial=0.0) < EXACT]
        apart = np.max(np.abs(exact[:, None] - exact[None]), axis=2, initial=0.0)
        first = ~np.any(np.tril(apart < SAME_RAD, -1), axis=1)
        return list(exact[first]), np.linalg.norm(off[:, :3, 3], axis=1)

    def inside(self, pose: Matrix) -> list[Joints]:
        """Return every answer inside all limits: each branch in each possible whole turn.

        Raises:
            OutOfReach: there is none; says how far away, or which limit every branch breaks first.
        """
        found = [q for branch in self._solve(pose)[0] for q in self._turns(branch)]
        found = found or list(self._shared(pose))
        if not found:
            self._refuse(pose)
        return found

    def _turns(self, branch: Joints) -> list[Joints]:
        """Return a branch in all whole turns that lie inside the limits."""
        rooms = []
        for value, low, high in zip(branch.tolist(), self._low, self._high, strict=True):
            first = value + tau * ceil((low - value) / tau)
            rooms.append([first + tau * k for k in range(int((high - first) // tau) + 1)])
        return [np.array(q) for q in product(*rooms)]

    def _shared(self, pose: Matrix, near: Joints | None = None, budget: Budget | None = None) -> Iterator[Joints]:
        """Yield answers at a singular pose, where a branch is only one of many, each the nearest to `near` of its kind.

        Raises:
            TooMuch: more singular poses than the budget allows.
        """
        asked, _ = self._asked(pose)
        answers = np.asarray(self._solver.IK(asked).Q, dtype=float).reshape(-1, len(self.chain.joints))
        about = singular.about_singular(self.chain, answers)
        there = [q for q in answers[about] if np.abs(self._solver.fwdKin(q)[:3, 3] - asked[:3, 3]).max() < CLOSE_M]
        for q in there:
            if budget is not None:
                budget.spend(SHARED)
            found = singular.nearest(self.chain, self._into(q), pose, self._into(q) if near is None else near)
            if found is not None:
                yield found
        beside = singular.polished(self.chain, near, pose, BESIDE) if near is not None and there else None
        if beside is not None and not self.chain.broken_limit(beside):
            yield beside

    def _refuse(self, pose: Matrix) -> NoReturn:
        found, miss = self._solve(pose)
        if not found:
            nearest = float(np.min(miss, initial=np.inf))
            raise OutOfReach(f"the tool would remain {nearest:.3f} m away: the arm is too short, or too long, for that")
        turned = self._into(np.array(found))
        outside = np.maximum(0.0, np.maximum(self.chain.low - turned, turned - self.chain.high))
        # branches often lie as far outside as their mirror images: then greater angles count
        far = np.sum(outside, axis=1)
        told = max(turned[far <= far.min() + ALIKE_RAD].tolist(), key=lambda q: [round(v / ALIKE_RAD) for v in q])
        raise OutOfReach(self.chain.broken_limit(np.array(told)))

    def _into(self, q: Joints) -> Joints:
        """Return `q` with each joint turned by a whole turn into its limits if possible."""
        low, high = self.chain.low, self.chain.high
        q = np.where((q < low) & (q + 2 * np.pi <= high + SLACK_RAD), q + 2 * np.pi, q)
        return np.where((q > high) & (q - 2 * np.pi >= low - SLACK_RAD), q - 2 * np.pi, q)
