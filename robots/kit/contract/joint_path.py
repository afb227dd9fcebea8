"""The path of a joint motion in a few knots: where the joints will be at each moment, before any state tells it."""

from dataclasses import dataclass
from functools import cached_property
from math import isfinite
from typing import Any

MOST_JOINTS = 16
MOST_KNOTS = 5
Row = tuple[float, ...]


@dataclass(frozen=True)
class JointPath:
    """A motion of the first joints of a spec (rad, m), from its beginning to rest after `seconds`.

    `knots` are 2 to 5 positions at equal times, the first where it begins, the last where it ends; `velocity` is that
    at the beginning (rad/s, m/s), empty if it begins at rest. Between the knots it is the cubic spline with that
    velocity at the beginning and none at the end; with two knots that is the polynomial of Craig 1986, section 7.3.
    Raises ValueError where the numbers are no path.
    """

    knots: tuple[Row, ...]
    seconds: float
    velocity: Row = ()

    def __post_init__(self) -> None:
        """Refuse what is no path. Raises ValueError."""
        joints = {len(row) for row in (*self.knots, *([self.velocity] if self.velocity else []))}
        if not 2 <= len(self.knots) <= MOST_KNOTS or len(joints) != 1 or not 1 <= max(joints) <= MOST_JOINTS:
            raise ValueError(f"a path has 2 to {MOST_KNOTS} knots of 1 to {MOST_JOINTS} joints")
        if not (isfinite(self.seconds) and self.seconds > 0):
            raise ValueError("a path takes some time")
        if not all(map(isfinite, (*(v for row in self.knots for v in row), *self.velocity))):
            raise ValueError("the numbers of a path are finite")

    def at(self, t: float) -> Row:
        """Return the joints (rad, m) at `t` s after the beginning; before it and after the end they rest."""
        return tuple(self._spline(min(max(t, 0.0), self.seconds)).tolist())

    @cached_property
    def _spline(self) -> Any:
        from scipy.interpolate import CubicSpline  # noqa: PLC0415 - pages import the contract, and need no arrays

        rest = (0.0,) * len(self.knots[0])
        pieces = len(self.knots) - 1
        times = [self.seconds * n / pieces for n in range(len(self.knots))]
        return CubicSpline(times, self.knots, bc_type=((1, self.velocity or rest), (1, rest)))
