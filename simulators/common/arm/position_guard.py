"""Checks where the measured arm may be (not its set-point), at each step of the control loop."""

import numpy as np

from robots.kit.arms.chain import Joints
from robots.kit.arms.planner import Planner

OFF_M = 0.005  # depth inside a box from which the measured arm counts as inside
OFF_RAD = 0.05  # the same for the range of a joint


def why_outside(planner: Planner, q: Joints) -> str:
    """Return what is wrong with the arm's position (rad), empty if nothing is."""
    distances = planner.zones.distances(q)
    touch = planner.zones.entered(distances + OFF_M, np.zeros_like(distances))
    if touch is not None:
        return str(touch)
    return planner.chain.broken_limit(q) if np.any(_outside(planner, q) > OFF_RAD) else ""


def _outside(planner: Planner, q: Joints) -> Joints:
    """Return how far each joint is outside its range (rad)."""
    limits = planner.limits
    return np.asarray(np.maximum(0.0, np.maximum(limits.low - q, q - limits.high)))


class PositionGuard:
    """Boxes and ranges for an arm that may already be outside them, and may then only move back."""

    def __init__(self, planner: Planner, q: Joints) -> None:
        self.accept(planner, q)

    def accept(self, planner: Planner, q: Joints) -> None:
        """Accept the present position; from there the arm may only move away."""
        self._planner = planner
        self._look(q)
        self._floor = planner.zones.floor(self._distances)
        self._most = _outside(planner, q) + OFF_RAD

    def _look(self, q: Joints) -> None:
        limits = self._planner.limits
        self._looked_at, self._distances = q.copy(), self._planner.zones.distances(q)
        self._way = (
            np.minimum(q - limits.low, limits.high - q) + OFF_RAD
        )  # of each joint, to its nearer limit and a tolerance

    def violation(self, q: Joints) -> str:
        """Return what is wrong with the arm's present position, empty if nothing is; it may not go back."""
        zones, moved = self._planner.zones, np.abs(q - self._looked_at)
        if (moved < self._way).all() and zones.still_clear(self._distances, moved):
            return ""  # the usual case: the arm is far from boxes and limits
        self._look(q)
        touch = zones.entered(self._distances + OFF_M, self._floor)
        if touch is not None:
            return str(touch)
        outside = _outside(self._planner, q)
        if (outside > self._most).any():
            return self._planner.chain.broken_limit(q)
        self._floor = zones.raised(self._floor, self._distances)
        self._most = np.minimum(self._most, outside + OFF_RAD)
        return ""
