"""The path of a joint motion in a few knots: where the joints will be at each moment, before any state tells it."""

from dataclasses import dataclass
from math import isfinite

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
        pieces = len(self.knots) - 1
        step = self.seconds / pieces
        t = min(max(t, 0.0), self.seconds)
        first = min(int(t / step), pieces - 1)
        s = t / step - first
        speeds = self._speeds(step)
        before, after = self.knots[first], self.knots[first + 1]
        return tuple(
            (2 * s**3 - 3 * s**2 + 1) * p + (s**3 - 2 * s**2 + s) * step * v
            + (3 * s**2 - 2 * s**3) * q + (s**3 - s**2) * step * w
            for p, q, v, w in zip(before, after, speeds[first], speeds[first + 1], strict=True)
        )  # fmt: skip

    def _speeds(self, step: float) -> list[Row]:
        """Return the velocities at the knots, by which also the acceleration is continuous (Thomas' algorithm)."""
        rest = (0.0,) * len(self.knots[0])
        begin, inner = self.velocity or rest, len(self.knots) - 2
        factors: list[float] = []
        rows: list[Row] = [begin]
        for n in range(1, inner + 1):
            pivot = 4.0 - (factors[-1] if factors else 0.0)
            factors.append(1.0 / pivot)
            ways = zip(self.knots[n - 1], self.knots[n + 1], rows[-1], strict=True)
            rows.append(tuple((3 * (q - p) / step - known) / pivot for p, q, known in ways))
        after: Row = rest
        found = [rest]
        for factor, row in zip(reversed(factors), reversed(rows[1:]), strict=True):
            after = tuple(known - factor * next_one for known, next_one in zip(row, after, strict=True))
            found.append(after)
        return [begin, *reversed(found)]
