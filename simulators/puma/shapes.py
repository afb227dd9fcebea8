"""Shapes of bodies that move: meshes in the body's frame with normals, because their light changes as they turn."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from simulators.common.mesh import SUN, WHITE, Colour, Mesh, joined
from simulators.puma.cell import Floats

SKY_LIGHT, SIDE_LIGHT, SUN_LIGHT = 0.60, 0.10, 0.42  # of all directions, more from above, of the lamp
SIDES = 20


@dataclass(frozen=True, eq=False)
class Shape:
    """A mesh without light, and the normal of each corner, shape (n, 3, 3)."""

    mesh: Mesh
    normals: Floats

    def lit(self, turn: Floats) -> Mesh:
        """Return the mesh as the lamp lights it with the body turned so (3 x 3)."""
        light = light_of(self.normals @ turn.T)
        return Mesh(self.mesh.corners, self.mesh.uv, light, self.mesh.tint, self.mesh.texture)

    def moved(self, pose: Floats) -> "Shape":
        """Return the shape in another frame; `pose` is 4 x 4."""
        return Shape(self.mesh.in_frame(pose), self.normals @ pose[:3, :3].T)


def light_of(normals: Floats) -> Floats:
    """Return the light on surfaces with these normals, (..., 3)."""
    return np.asarray(SKY_LIGHT + SIDE_LIGHT * normals[..., 2] + SUN_LIGHT * np.maximum(0.0, normals @ SUN))


def together(*shapes: Shape) -> Shape:
    """Return several shapes as one."""
    return Shape(joined(*(one.mesh for one in shapes)), np.concatenate([one.normals for one in shapes]))


def faces(corners: object, normals: object, tint: Colour = WHITE, texture: int = -1) -> Shape:
    """Return rectangles of corners (n, 4, 3), anticlockwise from the lower left, with normals of the same shape."""
    at, facing = np.asarray(corners, np.float64), np.asarray(normals, np.float64)
    where = np.array([[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]])
    order = np.array([[0, 1, 2], [0, 2, 3]])
    count = 2 * len(at)
    mesh = Mesh(
        at[:, order].reshape(-1, 3, 3), np.tile(where[order], (len(at), 1, 1)), np.ones((count, 3)),
        np.tile(tint, (count, 1)).astype(np.float64), np.full(count, texture),
    )  # fmt: skip
    return Shape(mesh, facing[:, order].reshape(-1, 3, 3))


def flat(middle: object, right: object, up: object, tint: Colour = WHITE, texture: int = -1) -> Shape:
    """Return a rectangle about a middle; `right` and `up` are half of its sides (m)."""
    m, a, b = (np.asarray(v, np.float64) for v in (middle, right, up))
    normal = np.cross(a, b) / np.linalg.norm(np.cross(a, b))
    return faces([[m - a - b, m + a - b, m + a + b, m - a + b]], np.tile(normal, (1, 4, 1)), tint, texture)


def box(half: object, tint: Colour) -> Shape:
    """Return a box about the origin with half edges (m)."""
    edges, sides = np.diag(np.asarray(half, np.float64)), []
    for k in range(3):
        a, b = edges[(k + 1) % 3], edges[(k + 2) % 3]
        sides += [flat(edges[k], a, b, tint), flat(-edges[k], b, a, tint)]
    return together(*sides)


def cylinder(radius: float, half: float, tint: Colour, sides: int = SIDES, bottom: bool = True) -> Shape:
    """Return a cylinder about the z axis (m), with rounded light, and with both ends."""
    angles = np.linspace(0, 2 * np.pi, sides + 1)
    ring = np.stack([np.cos(angles), np.sin(angles), np.zeros_like(angles)], axis=-1)
    rise, corners, normals, ends = np.array([0.0, 0.0, half]), [], [], []
    for a, b in pairwise(ring):
        corners.append([radius * a - rise, radius * b - rise, radius * b + rise, radius * a + rise])
        normals.append([a, b, b, a])
        ends.append([rise, radius * a + rise, radius * b + rise])
        if bottom:
            ends.append([-rise, radius * b - rise, radius * a - rise])
    flats, count = np.array(ends), len(ends)
    up = np.sign(flats[:, :, 2:]) * np.array([0.0, 0.0, 1.0])
    mesh = Mesh(flats, np.zeros((count, 3, 2)), np.ones((count, 3)), np.tile(tint, (count, 1)).astype(np.float64),
                np.full(count, -1))  # fmt: skip
    return together(faces(corners, normals, tint), Shape(mesh, up))


def tube(points: Floats, radius: float, tint: Colour) -> Mesh:
    """Return a thin line of four sides through points (n, 3) that runs about along z, with a light of its own."""
    square = radius * np.array([(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (-1.0, 0.0, 0.0), (0.0, -1.0, 0.0)])
    corners = [
        [low + a, low + b, high + b, high + a]
        for low, high in pairwise(points)
        for a, b in zip(square, np.roll(square, -1, axis=0), strict=True)
    ]
    return faces(corners, np.zeros((len(corners), 4, 3)), tint).mesh
