"""Dead reckoning from the wheels' encoders as the robot does it: its values of wheel radius and track have errors."""

from math import atan2, cos, sin, tau

import numpy as np
from numpy.typing import NDArray

from robots.kit.description import load

RADIUS_SHARE, TRACK_SHARE = 0.01, 0.02  # standard deviations of the systematic errors
ROUGH = 0.01  # standard deviation of an increment's error, as a share of the increment
TICKS_A_TURN = 4096  # of an encoder


class Odometry:
    """Pose (m, m, rad) and velocity (m/s, rad/s), zero at each start. The errors of a robot follow from its seed."""

    def __init__(self, seed: int, angles: NDArray[np.float64]) -> None:
        """`angles`: the wheels' now (left, right; rad)."""
        dice = np.random.default_rng(seed)
        body = load("irat")["body"]
        self._radii = body["wheel_radius"] * (1 + RADIUS_SHARE * dice.standard_normal(2))
        self._track = float(body["track"] * (1 + TRACK_SHARE * dice.standard_normal()))
        self._dice = dice
        self._ticks = _counted(angles)
        self.x = self.y = self.heading = 0.0
        self.linear = self.angular = 0.0

    def advance(self, angles: NDArray[np.float64], seconds: float) -> None:
        """Take the wheels' angles (left, right; rad) after so many seconds."""
        ticks = _counted(angles)
        turned = (ticks - self._ticks) * tau / TICKS_A_TURN
        self._ticks = ticks
        rough = 1 + ROUGH * self._dice.standard_normal(2) if turned.any() else 1.0
        left, right = (float(way) for way in turned * self._radii * rough)
        way, turn = (left + right) / 2, (right - left) / self._track
        self.x += way * cos(self.heading + turn / 2)
        self.y += way * sin(self.heading + turn / 2)
        self.heading = atan2(sin(self.heading + turn), cos(self.heading + turn))
        self.linear, self.angular = way / seconds, turn / seconds


def _counted(angles: NDArray[np.float64]) -> NDArray[np.int64]:
    return np.asarray(np.floor(angles * TICKS_A_TURN / tau), np.int64)
