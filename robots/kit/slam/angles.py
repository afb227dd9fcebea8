"""Angles (rad)."""

import math

from robots.kit.compiled import compiled

TURN = 2.0 * math.pi


@compiled
def wrapped(angle: float) -> float:
    """Return the same angle in [-pi, pi]."""
    if -math.pi <= angle <= math.pi:
        return angle
    return angle - TURN * math.floor((angle + math.pi) / TURN)
