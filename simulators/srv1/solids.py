"""Solids of which the exhibits are made, beside the common ones: balls, bones, discs, and lit sheets."""

from collections.abc import Callable
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from simulators.common.mesh import AMBIENT, DIFFUSE, SUN, WHITE, Colour, Mesh, joined, lamp, quad

Floats = NDArray[np.float64]
Place = tuple[float, float, float]
HALVES = ((0, 0), (0, 1), (1, 1)), ((0, 0), (1, 1), (1, 0))  # of a cell of a grid of (row, column)


def ball(
    middle: Place, radius: float, tint: Colour = WHITE, texture: int = -1, sides: int = 16, stretch: Place = (1, 1, 1)
) -> Mesh:
    """Return a ball; its texture is a map of longitude and latitude. `stretch`: along x, y and z."""
    rows, scale = sides // 2, np.asarray(stretch, float)
    i, j = (m.ravel() for m in np.meshgrid(np.arange(rows), np.arange(sides), indexing="ij"))
    three = [np.stack([np.stack([i + a, j + b], -1) for a, b in order], 1) for order in HALVES]
    share = np.concatenate(three) / (rows, sides)
    latitude, longitude = (share[..., 0] - 0.5) * np.pi, share[..., 1] * 2 * np.pi
    across = np.cos(latitude)
    normal = np.stack([across * np.cos(longitude), across * np.sin(longitude), np.sin(latitude)], -1)
    count = len(normal)
    facing = normal / scale
    facing /= np.linalg.norm(facing, axis=-1, keepdims=True)
    return Mesh(
        np.asarray(middle) + radius * normal * scale, np.stack([share[..., 1], 1 - share[..., 0]], -1),
        AMBIENT + DIFFUSE * np.maximum(0.0, facing @ SUN), np.tile(tint, (count, 1)).astype(float),
        np.full(count, texture),
    )  # fmt: skip


def bone(begin: Place, end: Place, radius: float, tint: Colour, thinner: float = 1.0, sides: int = 6) -> Mesh:
    """Return a rod from place to place (m), at its end so many times as thick."""
    a, b = np.asarray(begin, float), np.asarray(end, float)
    along = (b - a) / np.linalg.norm(b - a)
    across = np.cross(along, (0.0, 0.0, 1.0) if abs(along[2]) < 0.9 else (1.0, 0.0, 0.0))
    across /= np.linalg.norm(across)
    other, angles = np.cross(along, across), np.linspace(0, 2 * np.pi, sides + 1)
    ring = [radius * (np.cos(t) * across + np.sin(t) * other) for t in angles]
    return joined(*(
        quad([a + p, a + q, b + thinner * q, b + thinner * p], tint, light=lamp(p + q))
        for p, q in pairwise(ring)
    ))  # fmt: skip


def bones(places: list[Place], radius: float, tint: Colour, thinner: float = 1.0) -> Mesh:
    """Return rods along a row of places (m) with a ball at each; from place to place they get thinner."""
    parts = []
    for begin, end in pairwise(places):
        parts += [bone(begin, end, radius, tint, thinner), ball(begin, 1.25 * radius, tint, sides=6)]
        radius *= thinner
    return joined(*parts)


def disc(middle: Place, normal: Place, radius: float, texture: int, thick: float, tint: Colour) -> Mesh:
    """Return a disc with a texture on the face to which its normal points, and a rim."""
    n = np.asarray(normal, float) / np.linalg.norm(normal)
    across = np.cross((0.0, 0.0, 1.0), n) if abs(n[2]) < 0.9 else np.array([1.0, 0.0, 0.0])
    across /= np.linalg.norm(across)
    up, angles = np.cross(n, across), np.linspace(0, 2 * np.pi, 17)
    ring = [radius * (np.cos(t) * across + np.sin(t) * up) for t in angles]
    face = np.asarray(middle) + thick * n
    corners = np.stack([np.stack([face, face + p, face + q]) for p, q in pairwise(ring)])
    spread = np.array([[0.5 + 0.5 * np.cos(t), 0.5 - 0.5 * np.sin(t)] for t in angles])
    where = np.stack([np.stack([[0.5, 0.5], p, q]) for p, q in pairwise(spread)])
    front = Mesh(corners, where, np.full((16, 3), max(0.95, lamp(n))), np.full((16, 3), 255.0), np.full(16, texture))
    rim = [
        quad([face - thick * n + p, face - thick * n + q, face + q, face + p], tint, light=lamp(p + q))
        for p, q in pairwise(ring)
    ]
    return joined(front, *rim)


def sheet(
    corner: Place, right: Place, up: Place, cells: tuple[int, int], texture: int, repeats: tuple[float, float],
    light: Callable[[Floats], Floats], tint: Colour = WHITE,
) -> Mesh:  # fmt: skip
    """Return a rectangle of `cells` along `right` and `up` (m), whose light is a function of places (n, 3)."""
    j, i = (m.ravel() for m in np.meshgrid(np.arange(cells[1]), np.arange(cells[0]), indexing="ij"))
    three = [np.stack([np.stack([i + b, j + a], -1) for a, b in order], 1) for order in HALVES]
    share = np.concatenate(three) / cells
    corners = np.asarray(corner) + share[..., :1] * np.asarray(right, float) + share[..., 1:] * np.asarray(up, float)
    where = np.stack([share[..., 0] * repeats[0], (1 - share[..., 1]) * repeats[1]], -1)
    lights, count = light(corners.reshape(-1, 3)).reshape(-1, 3), len(corners)
    return Mesh(corners, where, lights, np.tile(tint, (count, 1)).astype(float), np.full(count, texture))
