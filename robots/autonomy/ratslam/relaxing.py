"""Relaxation: each link pulls its two experiences towards what the robot measured between them."""

import math

import numpy as np
from numpy.typing import NDArray

from robots.autonomy.compiled import compiled
from robots.autonomy.ratslam.angles import wrapped

Values = NDArray[np.float64]
Numbers = NDArray[np.int64]


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
            off_x = (poses[b, 0] - poses[a, 0] - measured[link, 0] * math.cos(towards)) * correction
            off_y = (poses[b, 1] - poses[a, 1] - measured[link, 0] * math.sin(towards)) * correction
            poses[a, 0] += off_x
            poses[a, 1] += off_y
            poses[b, 0] -= off_x
            poses[b, 1] -= off_y
            off = wrapped(poses[b, 2] - poses[a, 2] - measured[link, 2]) * correction
            poses[a, 2] = wrapped(poses[a, 2] + off)
            poses[b, 2] = wrapped(poses[b, 2] - off)
