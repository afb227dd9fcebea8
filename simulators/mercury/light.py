"""The light on the sand: one row of lamps from the side, light from the whole ceiling, and reflections.

The paper's lamps are fluorescent ones on the ceiling and two more "to reduce shadows and raise the overall ambient
light levels" (Goldberg et al. 1995, section 6.6).
"""

import numpy as np
from numpy.typing import NDArray

from simulators.mercury.artifacts import PIXEL_MM

F32 = NDArray[np.float32]
REACH = 24  # mm that a shadow can reach
DIRECTION = (-0.72, 0.69)  # where the light comes from, in the plane
SLOPE = float(np.tan(np.radians(33.0)))  # how steeply it falls
LAMP = 30.0  # how much brighter than white paper a lamp is in a mirror
SHINE = 50  # Blinn and Phong's exponent of a glossy surface


def illuminate(height: F32, albedo: F32, gloss: F32) -> F32:
    """Return the brightness of a surface seen from above: 1 is white paper lying flat.

    Heights in mm on the half-millimetre grid. Lambert's law, ambient light and cast shadows; a glossy surface shows
    the lamp where it is tilted half-way towards it.
    """
    slope_y, slope_x = (np.asarray(slope, np.float32) for slope in np.gradient(height, PIXEL_MM))
    steep = np.asarray(np.sqrt(1 + slope_x**2 + slope_y**2))
    lx, ly = DIRECTION
    lambert = np.clip((SLOPE - lx * slope_x - ly * slope_y) / steep / SLOPE, 0.0, 1.7)
    lit = 1 - 0.72 * _shadow(height)
    found = np.asarray(albedo * (0.34 + 0.66 * lambert * lit), np.float32)
    hx, hy, hz = _half_way()
    at = np.nonzero(gloss)  # a few things, and nowhere the sand
    mirrored = np.clip((hz - hx * slope_x[at] - hy * slope_y[at]) / steep[at], 0.0, 1.0) ** SHINE
    found[at] += LAMP * gloss[at] * mirrored * lit[at]
    return found


def _half_way() -> tuple[float, float, float]:
    """Return the unit vector half-way between the light and the camera above."""
    light = np.array([*DIRECTION, SLOPE])
    half = light / np.linalg.norm(light) + np.array([0.0, 0.0, 1.0])
    x, y, z = half / np.linalg.norm(half)
    return float(x), float(y), float(z)


def _shadow(height: F32) -> F32:
    lx, ly = DIRECTION
    edge = np.full(height.shape, -np.inf, np.float32)  # of the shadow: everything below it is dark
    for step in range(2, 30, 2):  # half millimetres towards the light
        other = np.roll(height, (-round(step * ly), -round(step * lx)), (0, 1))
        other -= np.float32(step * PIXEL_MM * SLOPE)
        np.maximum(edge, other, out=edge)
    return np.asarray(np.clip(edge - height, 0, 1.2) / np.float32(1.2), np.float32)
