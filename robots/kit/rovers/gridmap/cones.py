"""The nearest point of a surface inside a sensor's cone, of many surfaces and poses at once (m, rad).

Nothing hides what is nearest, so no ray has to be followed: of each wall the part inside the cone is taken, and of it
the nearest point. Shapes broadcast: the sensor's x, y, cosine and sine of its heading against the surfaces' last axis.
"""

from math import cos, sin, tan

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
TINY = 1e-300  # a segment along the side of a cone: it is inside or outside as a whole


def segments_away(segments: Floats, px: Floats, py: Floats, c: Floats, s: Floats, half_cone: float) -> Floats:
    """Return how far the part of each segment (..., 4: x, y, x, y) inside the cone is; infinite if no part is."""
    x, y = segments[..., 0] - px, segments[..., 1] - py
    ax, ay = x * c + y * s, y * c - x * s  # in the sensor's frame: x ahead, y left
    x, y = segments[..., 2] - segments[..., 0], segments[..., 3] - segments[..., 1]
    dx, dy = x * c + y * s, y * c - x * s
    slope = tan(half_cone)
    first, last = np.zeros_like(ax), np.ones_like(ax)
    for sign in (1.0, -1.0):  # each side of the cone: begin + u change >= 0, u from 0 to 1 along the segment
        begin, change = ax * slope + sign * ay, dx * slope + sign * dy
        change = np.where(change == 0.0, TINY, change)
        at, rises = -begin / change, change > 0.0
        first = np.where(rises, np.maximum(first, at), first)
        last = np.where(rises, last, np.minimum(last, at))
    u = np.minimum(np.maximum(-(ax * dx + ay * dy) / (x * x + y * y), first), last)
    ax, ay = ax + u * dx, ay + u * dy
    return np.where(first <= last, np.sqrt(ax * ax + ay * ay), np.inf)


def circles_away(circles: Floats, px: Floats, py: Floats, c: Floats, s: Floats, half_cone: float) -> Floats:
    """Return the same for circles (..., 3: x, y, radius): along the ray of the cone that is nearest to the middle."""
    x, y = circles[..., 0] - px, circles[..., 1] - py
    ax, ay = x * c + y * s, np.abs(y * c - x * s)
    along, aside = ax * cos(half_cone) + ay * sin(half_cone), ay * cos(half_cone) - ax * sin(half_cone)
    hit = circles[..., 2] ** 2 - aside**2
    grazed = np.where((along > 0.0) & (hit > 0.0), along - np.sqrt(np.maximum(hit, 0.0)), np.inf)
    return np.where((ax > 0.0) & (aside <= 0.0), np.hypot(ax, ay) - circles[..., 2], grazed)
