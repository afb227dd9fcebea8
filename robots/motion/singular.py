"""Singular poses of a serial arm, at which joints can turn against each other while the tool stands still."""

import numpy as np
from scipy.spatial.transform import Rotation

from robots.motion.chain import Chain, Joints, Matrix

EXACT = 1e-9  # m and rad
SLACK_RAD = 1e-9
POLISH = 8  # steps of Gauss and Newton
SAME = 1e-7  # tolerance of the pose while joints turn against each other (m and rad)
SINGULAR = 1e-4  # least singular value of the Jacobian, in m and rad


def singularity(chain: Chain, q: Joints, least: float = SINGULAR) -> str:
    """Return a sentence that names the joints of a singular pose `q`; empty if it is not singular."""
    _, values, rows = np.linalg.svd(chain.jacobian(q))
    if values[-1] > least:
        return ""
    share = np.abs(rows[-1])
    names = [j.name for j, s in zip(chain.joints, share, strict=True) if s > 0.2 * share.max()]
    if len(names) == 1:
        return f"a singular pose: turning {names[0]} does not move the tool"
    return f"a singular pose: turning {', '.join(names[:-1])} and {names[-1]} against each other does not move the tool"


def share(chain: Chain, q: Joints, pose: Matrix) -> Joints | None:
    """Return joints inside the limits that put the tool at `pose`, found from the singular answer `q`.

    A closed form gives only one of many answers there, or an approximate one. None if none is inside.
    """
    polished = _polished(chain, q, pose)
    return None if polished is None else _slid(chain, polished)


def _polished(chain: Chain, q: Joints, pose: Matrix) -> Joints | None:
    """Return `q` moved onto the pose by a few steps of Gauss and Newton; None if they do not converge."""
    for _ in range(POLISH):
        here = chain.forward(q)
        turn = Rotation.from_matrix(pose[:3, :3] @ here[:3, :3].T).as_rotvec()
        off = np.concatenate([pose[:3, 3] - here[:3, 3], turn])
        if np.max(np.abs(off)) < EXACT:
            return q
        q = q + np.linalg.pinv(chain.jacobian(q), rcond=1e-6) @ off
    return None


def _slid(chain: Chain, q: Joints) -> Joints | None:
    """Return `q` moved into the limits if it is singular, by joints that turn against each other."""
    _, values, rows = np.linalg.svd(chain.jacobian(q))
    if values[-1] > SINGULAR:
        return None
    way, low, high = rows[-1], chain.low - q, chain.high - q
    turns = np.abs(way) > 1e-6
    if np.any(low[~turns] > SLACK_RAD) or np.any(high[~turns] < -SLACK_RAD):
        return None
    ends = np.sort(np.array([low[turns], high[turns]]) / way[turns], axis=0)
    first, last = float(np.max(ends[0])), float(np.min(ends[1]))
    if first > last + SLACK_RAD:
        return None
    slid = np.clip(q + way * min(max(0.0, first), last), chain.low, chain.high)
    off = chain.forward(slid) - chain.forward(q)
    return slid if bool(np.max(np.abs(off)) < SAME) else None
