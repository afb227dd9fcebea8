"""Judges what the controller of a simulated arm asks of it."""

import numpy as np

from robots.kit.arms.path import Limits
from simulators.common.arm.setpoint import Reference
from simulators.common.journal import Note

SLACK = 1e-4  # rad, rad/s


class ReferenceJudge:
    """Writes a set-point outside ranges or speeds to the journal as `passed`, once each time; there must be none."""

    def __init__(self, limits: Limits, note: Note, first: Reference) -> None:
        self._limits, self._note = limits, note
        self.newest = first
        self._passed = False  # the set-point is outside its limits

    def look(self, reference: Reference, excused: bool) -> None:
        """Judge the next set-point; `excused`: it is where the arm was pushed."""
        limits, before = self._limits, self.newest
        self.newest = reference
        if (reference.q is before.q and reference.v is before.v) or excused:
            return  # it rests
        inside = ((reference.q > limits.low - SLACK) & (reference.q < limits.high + SLACK)).all()
        passed = not (inside and (np.abs(reference.v) < limits.velocity + SLACK).all())  # also if it is NaN
        if passed and not self._passed:
            self._note("passed", q=np.round(reference.q, 4).tolist(), v=np.round(reference.v, 4).tolist())
        self._passed = passed
