"""Distances of segments to axis-aligned boxes, many at once (m)."""

import numpy as np

from robots.kit.arms.chain import Matrix


def at_least(begin: Matrix, end: Matrix, low: Matrix, high: Matrix) -> Matrix:
    """Return lower bounds of the distances: those of the smallest boxes around the segments. Ten times as quick."""
    gaps = np.maximum(low - np.maximum(begin, end), np.minimum(begin, end) - high)
    found: Matrix = np.sqrt(np.sum(np.square(np.maximum(gaps, 0.0)), axis=-1))
    return found


def exactly(begin: Matrix, end: Matrix, low: Matrix, high: Matrix) -> Matrix:
    """Return the distances (m) of segments to boxes, (..., p), their corners (..., p, 3) and (p, 3).

    The squared distance to a convex box is convex along a segment, and its slope is linear
    between the places where the segment crosses the plane of a face: so the least distance is
    where the slope crosses zero, between two such places.
    """
    way = end - begin
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        cuts = np.concatenate([(low - begin) / way, (high - begin) / way], axis=-1)
    ends = np.broadcast_to([0.0, 1.0], (*way.shape[:-1], 2))
    cuts = np.where(cuts > 0.0, np.minimum(cuts, 1.0), 0.0)  # 0 if it does not cross
    t = np.sort(np.concatenate([cuts, ends], axis=-1), axis=-1)
    at = begin[..., None, :] + t[..., None] * way[..., None, :]
    off = at - np.clip(at, low[..., None, :], high[..., None, :])
    slope = np.einsum("...kj,...j->...k", off, way)
    rising = np.maximum(np.argmax(slope >= 0.0, axis=-1), 1)  # the first place after which the distance grows
    rising = np.where(slope[..., -1] < 0.0, slope.shape[-1] - 1, rising)[..., None]
    before, after = np.take_along_axis(slope, rising - 1, -1), np.take_along_axis(slope, rising, -1)
    first, then = np.take_along_axis(t, rising - 1, -1), np.take_along_axis(t, rising, -1)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        share = np.where(before >= 0.0, 0.0, np.where(after <= 0.0, 1.0, -before / (after - before)))
    nearest = begin + (first + share * (then - first)) * way
    found: Matrix = np.linalg.norm(nearest - np.clip(nearest, low, high), axis=-1)
    return found
