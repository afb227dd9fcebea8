"""A scan in place: readings of sonar and infrared in each direction."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import remainder, tau

import numpy as np

from robots.kit.rovers.gridmap.plan import Floats
from robots.kit.rovers.gridmap.turns import COMPASS_SPREAD, MOST, headings_of

TURNS = 18  # of 20 degrees
COMPASS_BIAS = 0.05  # rad, of all readings of one scan: iron, and how north was set


@dataclass(frozen=True)
class Scan:
    """Readings of one scan in place, each (n,): `turned` (rad, to the left), `sonar`, `infrared` (m).

    turned: the heading of each less that of the last, which is how the rover stands now. heading: of the last (rad),
    with its standard deviation; None where no compass told it.
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
    """Return the scan of what was read.

    turns (n - 1): what the encoders tell of the turns between readings (rad, to the left, without slip); compass (n):
    headings (rad, to the left from +x); sonar, infrared (n): m. Raises ValueError for other lengths or numbers.
    """
    headings = headings_of(np.asarray(turns, float), np.asarray(compass, float))
    turned = headings - headings[-1]
    spread = float(np.hypot(COMPASS_BIAS, COMPASS_SPREAD / np.sqrt(len(headings))))
    heading = remainder(float(headings[-1]), tau)
    return Scan(turned, np.asarray(sonar, float), np.asarray(infrared, float), heading, spread)
