"""How an object swings that hangs on threads: a pendulum that is fitted to where it was seen when. Pure; m, s, rad."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import atan2, ceil, cos, hypot, pi, sqrt

import numpy as np

from robots.kit.arms.chain import Matrix

GRAVITY = 9.81
FEWEST = 4  # places from which a swing is told


@dataclass(frozen=True, eq=False)
class Swing:
    """A level swing to and fro through `middle` (x, y), along `way` (of length one): `far` to each side.

    Its place on the way is `far` cos(`rate` t - `phase`) at a time t. `off` is how far the places that were seen are
    from that (root mean square).
    """

    middle: Matrix
    way: Matrix
    far: float
    rate: float
    phase: float
    off: float

    def turns(self, after: float) -> tuple[float, Matrix]:
        """Return when it turns for the first time after a time, and where that is (x, y): there it is slowest."""
        number = ceil((self.rate * after - self.phase) / pi)
        return (number * pi + self.phase) / self.rate, self.middle + (-1) ** number * self.far * self.way

    def at(self, time: float) -> Matrix:
        """Return where it is at a time (x, y)."""
        return np.asarray(self.middle + self.far * cos(self.rate * time - self.phase) * self.way)


def height(length: float, rest: Matrix, at: Matrix) -> float:
    """Return how high is, at (x, y, ...), what rests at `rest` (x, y, z) on threads of a length."""
    aside = min(length, float(np.hypot(*(at[:2] - rest[:2]))))
    return float(rest[2]) + length - sqrt(length**2 - aside**2)


def fitted(times: Sequence[float], places: Sequence[Matrix], length: float) -> Swing | None:
    """Return the swing on threads of a length of what was at these places (x, y, ...); None from fewer than four."""
    if len(times) < FEWEST:
        return None
    rate, when, seen = sqrt(GRAVITY / length), np.array(times), np.array(places)[:, :2]
    begin = when[0]
    turned = rate * (when - begin)
    known = np.stack([np.ones_like(turned), np.cos(turned), np.sin(turned)], axis=1)
    middle, a, b = np.linalg.lstsq(known, seen, rcond=None)[0]
    way = np.linalg.svd(np.stack([a, b]))[2][0]
    along, across = float(a @ way), float(b @ way)
    rest = seen - known @ np.stack([middle, along * way, across * way])
    phase = atan2(across, along) + rate * float(begin)
    return Swing(middle, way, hypot(along, across), rate, phase, float(np.sqrt(np.mean(np.sum(rest**2, axis=1)))))
