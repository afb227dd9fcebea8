"""Singular poses of a serial arm, at which joints can turn against each other while the tool stands still."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from robots.kit.arms.chain import Chain, Joints, Matrix

EXACT = 1e-9  # m and rad
SLACK_RAD = 1e-9
TURN, TURNS = 2 * np.pi, range(-2, 3)  # rad; whole turns that may lie inside the limits of two joints together
POLISH = 8  # steps of Gauss and Newton
SAME = 1e-7  # tolerance of the pose while joints turn against each other (m and rad)
EVEN_S = 1e-12  # answers whose costs (s at full speed) differ by less are equally near
SINGULAR, ABOUT = 1e-4, 1e-2  # least singular value of the Jacobian, in m and rad; of an approximate answer


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


def about_singular(chain: Chain, q: Joints) -> NDArray[np.bool_]:
    """Return which of the (m, n) joint vectors `q`, which may be approximate, can belong to a singular pose."""
    return np.asarray(np.linalg.svd(chain.jacobian(q), compute_uv=False)[:, -1] <= ABOUT)


def nearest(chain: Chain, q: Joints, pose: Matrix, near: Joints) -> Joints | None:
    """Return joints inside the limits that put the tool at `pose`, found from the singular answer `q`.

    A closed form gives only one of many answers there, or an approximate one. Of those between which the joints turn
    against each other in proportion, the one is chosen whose slowest joint has the shortest way from `near`. None if
    none is inside, or `q` is not singular.
    """
    begin = polished(chain, q, pose)
    if begin is None:
        return None
    _, values, rows = np.linalg.svd(chain.jacobian(begin))
    ways = rows[values <= SINGULAR]
    if not len(ways):
        return None
    found = [end for turn in TURNS if (end := _slid(chain, begin, ways, near, turn)) is not None]
    there = chain.forward(begin)
    found = [end for end in found if np.max(np.abs(chain.forward(end) - there)) < SAME]
    return nearest_of(chain, found, near)


def nearest_of(chain: Chain, answers: Iterable[Joints], near: Joints) -> Joints | None:
    """Return the answer whose slowest joint has the shortest way from `near`; of equal ones, whose joints move less."""
    best, least, squares = None, np.inf, np.inf
    for q in answers:
        ways = np.abs(q - near) / chain.velocity
        slowest, all_ways = float(np.max(ways)), float(np.sum(np.square(ways)))
        if slowest < least - EVEN_S or (slowest <= least + EVEN_S and all_ways < squares):
            best, least, squares = q, slowest, all_ways
    return best


def polished(chain: Chain, q: Joints, pose: Matrix, least: float = 1e-6) -> Joints | None:
    """Return `q` moved onto the pose by a few steps of Gauss and Newton; None if they do not converge.

    `least`: directions in which the tool hardly moves, by their share of the greatest singular value, are left alone.
    """
    for _ in range(POLISH):
        here = chain.forward(q)
        turn = Rotation.from_matrix(pose[:3, :3] @ here[:3, :3].T).as_rotvec()
        off = np.concatenate([pose[:3, 3] - here[:3, 3], turn])
        if np.max(np.abs(off)) < EXACT:
            return q
        q = q + np.linalg.pinv(chain.jacobian(q), rcond=least) @ off
    return None


def _slid(chain: Chain, q: Joints, ways: Matrix, near: Joints, turn: int) -> Joints | None:
    """Return `q`, moved along each of `ways` into the limits and as near to `near` as it goes; None if not inside.

    `turn`: so many whole turns are added to a joint that turns.
    """
    q = q + TURN * turn * (np.arange(len(q)) == np.argmax(np.abs(ways[0])))
    q = q + (near - q) @ ways.T @ ways
    for way in ways:
        turns = np.abs(way) > 1e-6
        ends = np.sort(np.array([chain.low[turns] - q[turns], chain.high[turns] - q[turns]]) / way[turns], axis=0)
        first, last = float(np.max(ends[0])), float(np.min(ends[1]))
        if first > last + SLACK_RAD:
            return None
        # the slowest joint's time is the greatest of lines over the way; it is least at an end, or where two meet;
        # where that leaves a choice, the squares of all times decide
        own, own_pace = (q - near) / chain.velocity, way / chain.velocity
        off, pace = np.concatenate([own, -own]), np.concatenate([own_pace, -own_pace])
        steeper = pace[:, None] - pace
        meet = ((off - off[:, None])[np.abs(steeper) > 1e-9]) / steeper[np.abs(steeper) > 1e-9]
        tried = np.clip([first, last, -(own @ own_pace) / (own_pace @ own_pace), *meet], first, last)
        slowest = np.max(off + pace * tried[:, None], axis=1)
        squares = np.sum(np.square(own + own_pace * tried[:, None]), axis=1)
        q = q + way * tried[np.argmin(np.where(slowest <= slowest.min() + EVEN_S, squares, np.inf))]
    return None if chain.broken_limit(q, 1e-6) else np.clip(q, chain.low, chain.high)
