"""Angles, and what a compass tells of a heading."""

from math import tau

import numpy as np

from robots.kit.rovers.gridmap.plan import Floats
from robots.kit.rovers.gridmap.scan import Scan

HEADING_OUTLIER = 0.02  # share of compass headings that iron has spoilt


def angle(turned: Floats) -> Floats:
    """Return angles between -pi and pi (rad)."""
    return np.asarray(np.remainder(turned + np.pi, tau) - np.pi, float)


def facing(headings: Floats, scan: Scan, step: float) -> Floats:
    """Return how likely headings (rad) are by the scan's compass; `step`: how far they are apart."""
    wide = float(np.hypot(scan.heading_spread, 0.3 * step))
    near = np.exp(-0.5 * (angle(headings - (scan.heading or 0.0)) / wide) ** 2) / (wide * np.sqrt(tau))
    return np.asarray((1.0 - HEADING_OUTLIER) * near + HEADING_OUTLIER / tau, float)
