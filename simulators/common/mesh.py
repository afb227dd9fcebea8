"""Meshes of triangles for the rasteriser, and the solids that scenes are built of.

A triangle is seen from the side from which its corners run anticlockwise.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Colour = tuple[float, float, float]
SUN = np.array([0.35, -0.5, 0.8]) / np.linalg.norm([0.35, -0.5, 0.8])
AMBIENT, DIFFUSE = 0.68, 0.36
WHITE: Colour = (255.0, 255.0, 255.0)


@dataclass(frozen=True)
class Mesh:
    """Triangles: corners (n, 3, 3) in m, uv (n, 3, 2), light (n, 3), tint (n, 3), texture (n,) or -1 for none."""

    corners: Floats
    uv: Floats
    light: Floats
    tint: Floats
    texture: NDArray[np.int64]

    def in_frame(self, pose: Floats) -> "Mesh":
        """Return the mesh in another frame; `pose` is 4 x 4."""
        return Mesh(self.corners @ pose[:3, :3].T + pose[:3, 3], self.uv, self.light, self.tint, self.texture)

    def lit(self, share: float) -> "Mesh":
        """Return the mesh with so many times its light."""
        return Mesh(self.corners, self.uv, self.light * share, self.tint, self.texture)


def joined(*meshes: Mesh) -> Mesh:
    """Return several meshes as one."""
    return Mesh(*(np.concatenate([getattr(m, name) for m in meshes]) for name in Mesh.__dataclass_fields__))


def quad(
    corners: object, tint: Colour = WHITE, texture: int = -1, uv: object = None, light: float | None = None,
    darker: float = 1.0,
) -> Mesh:  # fmt: skip
    """Return a rectangle of four corners, anticlockwise from the lower left, with u to the right and v downwards.

    `light`: None for that of the lamp; the first two corners have `darker` times as much.
    """
    at = np.asarray(corners, np.float64)
    where = np.array([[0, 1], [1, 1], [1, 0], [0, 0]] if uv is None else uv, np.float64)
    normal = np.cross(at[1] - at[0], at[3] - at[0])
    lit = lamp(normal) if light is None else light
    order = np.array([[0, 1, 2], [0, 2, 3]])
    lights = lit * np.array([darker, darker, 1.0, 1.0])
    return Mesh(at[order], where[order], lights[order], np.tile(tint, (2, 1)).astype(float), np.full(2, texture))


def lamp(normal: Floats) -> float:
    """Return how bright the lamp makes a surface with this normal."""
    length = float(np.linalg.norm(normal))
    return AMBIENT + DIFFUSE * max(0.0, float(normal @ SUN) / length) if length else AMBIENT


def prism(outline: Floats, low: float, high: float, tint: Colour, texture: int = -1, top: bool = True) -> Mesh:
    """Return the solid over a convex outline (n, 2), anticlockwise, from `low` to `high` (m)."""
    sides = [
        quad([(*a, low), (*b, low), (*b, high), (*a, high)], tint, texture, darker=0.72)
        for a, b in pairwise([*outline, outline[0]])
    ]
    return joined(*sides, lid(outline, high, tint)) if top else joined(*sides)


def lid(outline: Floats, high: float, tint: Colour) -> Mesh:
    """Return a convex outline (n, 2), anticlockwise, as a level surface seen from above."""
    count = len(outline) - 2
    at = np.column_stack([outline, np.full(len(outline), high)])
    corners = np.stack([np.stack([at[0], at[i], at[i + 1]]) for i in range(1, len(outline) - 1)])
    light = np.full((count, 3), lamp(np.array([0.0, 0.0, 1.0])))
    return Mesh(corners, np.zeros((count, 3, 2)), light, np.tile(tint, (count, 1)).astype(float), np.full(count, -1))


def box(low: object, high: object, tint: Colour, texture: int = -1) -> Mesh:
    """Return a box between two corners (m), without its underside."""
    (x, y, z), (a, b, c) = np.asarray(low, float), np.asarray(high, float)
    return prism(np.array([(x, y), (a, y), (a, b), (x, b)]), z, c, tint, texture)


def turned(profile: object, tint: Colour, sides: int = 12) -> Mesh:
    """Return the solid of a profile of (radius, height), from bottom to top, turned about the z axis."""
    angles = np.linspace(0, 2 * np.pi, sides + 1)
    parts = []
    for (r, z), (s, h) in pairwise(np.asarray(profile, float)):
        for a, b in pairwise(angles):
            ring = [(r * np.cos(a), r * np.sin(a), z), (r * np.cos(b), r * np.sin(b), z),
                    (s * np.cos(b), s * np.sin(b), h), (s * np.cos(a), s * np.sin(a), h)]  # fmt: skip
            middle, slope = (a + b) / 2, np.arctan2(s - r, h - z)
            normal = np.array([np.cos(middle) * np.cos(slope), np.sin(middle) * np.cos(slope), -np.sin(slope)])
            parts.append(quad(ring, tint, light=lamp(normal)))
    return joined(*parts)


def placed(x: float, y: float, z: float, heading: float = 0.0) -> Floats:
    """Return a pose (4 x 4): at a place (m), turned about the vertical (rad)."""
    pose = np.eye(4)
    c, s = np.cos(heading), np.sin(heading)
    pose[:2, :2] = [[c, -s], [s, c]]
    pose[:3, 3] = x, y, z
    return pose
