"""The path of an arm in a few knots, as viewers are told it (`robots.kit.contract.joint_path`)."""

import numpy as np
import scipy.interpolate  # noqa: F401 - a path needs it, and no motion waits until it is loaded

from robots.kit.arms.path import Cubic, Path
from robots.kit.contract.joint_path import MOST_KNOTS, JointPath

SAMPLES = 40  # moments at which a spline is compared with the path
NEAR_RAD = 0.003  # a spline that stays so near needs no further knot
FARTHEST_RAD = 0.03  # one that leaves the path farther than this is of no use


def knots_of(path: Path) -> JointPath | None:
    """Return the knots of a path that begins now and ends at rest; None for one that so few knots do not describe.

    A third-order polynomial needs two, and its velocity at the beginning. Any other path has to begin at rest.
    """
    _, velocity, _ = path.at(0.0)
    moving = bool(np.any(np.abs(velocity) > 0))
    if isinstance(path, Cubic):
        return _spline(path, 2, velocity if moving else None)
    if moving:
        return None
    times = np.linspace(0.0, path.seconds, SAMPLES)
    wanted, found, off = path.sample(times), None, np.inf
    for many in range(3, MOST_KNOTS + 1):
        tried = _spline(path, many, None)
        farthest = float(np.abs(np.array([tried.at(float(t)) for t in times]) - wanted).max())
        if farthest < off:
            found, off = tried, farthest
        if off <= NEAR_RAD:
            break
    return found if off <= FARTHEST_RAD else None


def _spline(path: Path, many: int, velocity: np.ndarray | None) -> JointPath:
    rows = path.sample(np.linspace(0.0, path.seconds, many)).tolist()
    return JointPath(
        tuple(map(tuple, rows)), path.seconds, () if velocity is None else tuple(velocity.tolist())
    )  # fmt: skip
