"""A scan in place: readings of sonar and infrared in each direction, and the headings at which they were taken.

Wheels slip and a compass is noisy; together they tell the headings much more exactly than either alone.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import remainder, tau

import numpy as np

from robots.kit.rovers.gridmap.plan import Floats

TURNS = 18  # of 20 degrees
SLIP, SLIP_SPREAD = 0.22, 0.10  # of a turn: 10 to 35 %, the same during one scan
STEP_SPREAD = 0.02  # rad, of one turn besides
COMPASS_SPREAD = 0.05  # rad, of one reading
MOST = 360  # readings of one scan
HEADING_OUTLIER = 0.02  # share of compass headings that iron has spoilt
COMPASS_BIAS = 0.05  # rad, of all readings of one scan: iron, and how north was set


@dataclass(frozen=True)
class Scan:
    """Readings of one scan in place, each (n,): `turned` (rad, to the left), `sonar`, `infrared` (m).

    turned: the heading of each less that of the last, which is how the rover stands now. heading: of the last (rad),
    with its standard deviation; None without a compass.
    """

    turned: Floats
    sonar: Floats
    infrared: Floats
    heading: float | None = None
    heading_spread: float = COMPASS_BIAS

    def __post_init__(self) -> None:
        """Refuse what no sensor can have read: ValueError."""
        arrays = self.turned, self.sonar, self.infrared
        if not 1 <= len(self.turned) <= MOST or any(a.shape != (len(self.turned),) for a in arrays):
            raise ValueError(f"A scan has 1 to {MOST} readings of each kind.")
        if (
            not all(np.isfinite(a).all() and (np.abs(a) < 1e3).all() for a in arrays)
            or min(self.sonar.min(), self.infrared.min()) < 0.0
        ):
            raise ValueError("A scan's readings are finite numbers, and ranges are not negative.")
        known = self.heading is None or abs(self.heading) < 1e3
        if not (known and 0.0 < self.heading_spread < 1e3):
            raise ValueError("A heading is a finite number with a spread above 0.")


def scan_of(
    turns: Sequence[float], compass: Sequence[float], sonar: Sequence[float], infrared: Sequence[float]
) -> Scan:
    """Return the scan of these readings.

    turns (n - 1): the turns between readings by the encoders (rad, to the left, without slip); compass (n): headings
    (rad, to the left from +x); sonar, infrared (n): m. Raises ValueError for other lengths or numbers.
    """
    headings = headings_of(np.asarray(turns, float), np.asarray(compass, float))
    turned = headings - headings[-1]
    spread = float(np.hypot(COMPASS_BIAS, COMPASS_SPREAD / np.sqrt(len(headings))))
    heading = remainder(float(headings[-1]), tau)
    return Scan(turned, np.asarray(sonar, float), np.asarray(infrared, float), heading, spread)


def headings_of(turns: Floats, compass: Floats) -> Floats:
    """Return the likeliest headings (n,) by n - 1 turns of the encoders and n readings of the compass (rad).

    Least squares for the headings and the slip that all turns share. Raises ValueError for other lengths or numbers.
    """
    count = len(compass)
    if not 1 <= count <= MOST or turns.shape != (count - 1,):
        raise ValueError("There is one turn fewer than readings of the compass.")
    if not (np.isfinite(turns).all() and np.isfinite(compass).all() and (np.abs(turns) < tau).all()):
        raise ValueError("Turns and headings are finite numbers.")
    ahead = (1.0 - SLIP) * turns
    steps = ahead + np.remainder(np.diff(compass) - ahead + np.pi, tau) - np.pi
    seen = compass[0] + np.concatenate([[0.0], np.cumsum(steps)])
    encoders = np.column_stack([np.diff(np.eye(count), axis=0), turns]) / STEP_SPREAD
    slip = np.eye(1, count + 1, count) / SLIP_SPREAD
    left = np.vstack(
        [encoders, np.eye(count, count + 1) / COMPASS_SPREAD, slip]
    )  # unknown: the headings, then the slip
    right = np.concatenate([turns / STEP_SPREAD, seen / COMPASS_SPREAD, [SLIP / SLIP_SPREAD]])
    return np.asarray(np.linalg.lstsq(left, right, rcond=None)[0][:count], float)


def angle(turned: Floats) -> Floats:
    """Return angles between -pi and pi (rad)."""
    return np.asarray(np.remainder(turned + np.pi, tau) - np.pi, float)


def facing(headings: Floats, scan: Scan, step: float) -> Floats:
    """Return how likely headings (rad) are by the scan's compass; `step`: how far they are apart."""
    wide = float(np.hypot(scan.heading_spread, 0.3 * step))
    near = np.exp(-0.5 * (angle(headings - (scan.heading or 0.0)) / wide) ** 2) / (wide * np.sqrt(tau))
    return np.asarray((1.0 - HEADING_OUTLIER) * near + HEADING_OUTLIER / tau, float)
