"""Learns the error with which the odometry measures turns, from places that the robot sees again.

A wheel that is 1 % larger than the other one bends every metre by 10 degrees, and a wrong track stretches every turn.
Between two visits of one experience the robot has turned by whole turns and the small angle that the pose cells tell.
So each pair of visits is a measurement of `scale * turned + bend * gone`, for a Kalman filter of the two numbers.
"""

import math
from dataclasses import dataclass

SCALE_SD, BEND_SD = 0.03, 0.25  # standard deviations of the first estimate, which is 1 and 0 rad/m
SEEN_SD = 0.15  # rad: how well the pose cells tell the heading beside an experience
DRIFT_SD = 0.002, 0.01  # how much the two numbers may change from one use to the next
LEAST_M = 0.5  # a shorter way tells nothing, and a visit so soon after the last one that was used tells nothing new
GATE = 3.0  # standard deviations
SCALE_MOST, BEND_MOST = 0.1, 1.0  # no wheels of this kind are worse
PATIENCE = 5  # disagreements less agreements, after which the estimate begins anew


@dataclass
class Calibration:
    """turning = scale * measured + bend * distance. `a`, `b`, `c`: variances of scale and bend, and their covariance.

    `turned` (rad, as measured) and `distance` (m; backwards counts against it): since the robot was switched on.
    """

    scale: float = 1.0
    bend: float = 0.0
    a: float = SCALE_SD**2
    b: float = BEND_SD**2
    c: float = 0.0
    turned: float = 0.0
    distance: float = 0.0
    uses: int = 0
    used_at: float = 0.0
    doubted: int = 0

    def correct(self, distance: float, turn: float) -> float:
        """Count a step of odometry (m, rad) and return how far the robot turned (rad)."""
        self.turned += turn
        self.distance += distance
        return self.scale * turn + self.bend * distance

    def visited(self, turned: float, gone: float, facing: float) -> bool:
        """Learn from a return to an experience; tell whether the visit was used.

        turned, gone: what was counted at the last visit; facing: how much more the robot is turned against the
        experience than then (rad).
        """
        w, s = self.turned - turned, self.distance - gone
        if s < LEAST_M or self.distance - self.used_at < LEAST_M:
            return False
        spread = w * w * self.a + 2.0 * w * s * self.c + s * s * self.b + SEEN_SD**2
        off = math.remainder(facing - (self.scale * w + self.bend * s), 2.0 * math.pi)
        if GATE * math.sqrt(spread) > math.pi:
            return False  # the number of whole turns is not certain
        if abs(off) > GATE * math.sqrt(spread):  # another place that looks alike, or a wrong estimate
            self.doubted += 1
            if self.doubted >= PATIENCE:
                self._forget()
            return False
        by_w, by_s = self.a * w + self.c * s, self.c * w + self.b * s
        self.scale = max(1.0 - SCALE_MOST, min(self.scale + by_w / spread * off, 1.0 + SCALE_MOST))
        self.bend = max(-BEND_MOST, min(self.bend + by_s / spread * off, BEND_MOST))
        self.a += DRIFT_SD[0] ** 2 - by_w * by_w / spread
        self.b += DRIFT_SD[1] ** 2 - by_s * by_s / spread
        self.c -= by_w * by_s / spread
        self.uses, self.used_at, self.doubted = self.uses + 1, self.distance, max(0, self.doubted - 1)
        return True

    def _forget(self) -> None:
        self.scale, self.bend, self.doubted = 1.0, 0.0, 0
        self.a, self.b, self.c = SCALE_SD**2, BEND_SD**2, 0.0
