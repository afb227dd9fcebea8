"""Pictures of a scene of triangles on the CPU: a z-buffer in numba, with no graphics library.

Triangles are drawn in two passes: the first finds the nearest triangle of each pixel, the second reads its texture
once a pixel. Textures have mipmaps, so that a small or distant pattern is averaged, as a lens does. A pinhole camera
without distortion; one thread; the interpreter's lock is released.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from simulators.common.mesh import Mesh
from simulators.common.texture import Atlas

Floats = NDArray[np.float64]
Picture = NDArray[np.uint8]
NEAR_M = 0.004
SEAM_PX = 1e-4  # triangles overlap by so much, so that no pixel between two is left out
PLANES = 17  # per triangle: 1/z, u/z, v/z, light/z as x, y and constant parts; texture, its area in texels, tint
NOISE_BANK = 1 << 20


@dataclass(frozen=True)
class Lens:
    """A pinhole camera: pixels, and the horizontal field of view in rad."""

    width: int
    height: int
    field: float

    @property
    def focal(self) -> float:
        """Return the focal length in pixels."""
        return self.width / 2 / float(np.tan(self.field / 2))


class Canvas:
    """Draws meshes as one lens sees them. Not thread safe: one canvas a thread."""

    def __init__(self, lens: Lens, atlas: Atlas, noise: int = 0, seed: int = 1) -> None:
        """`noise`: the sensor's, in grey levels in both directions."""
        self.lens, self._atlas = lens, atlas
        shape = (lens.height, lens.width)
        self._depth = np.zeros(shape, np.float32)  # 1/z, 0 where nothing was drawn
        self._owner = np.full(shape, -1, np.int32)
        self._picture = np.zeros((*shape, 3), np.uint8)
        self._planes = np.zeros((1024, PLANES))
        self._count = 0
        self._kept: tuple[NDArray[np.float32], NDArray[np.int32], Picture, int] | None = None
        self._dice = np.random.default_rng(seed)
        self._grain = self._dice.integers(-noise, noise, NOISE_BANK if noise else 1, dtype=np.int8, endpoint=True)

    def begin(self) -> None:
        """Empty the canvas, but for what is kept."""
        if self._kept is None:
            self._depth.fill(0.0)
            self._owner.fill(-1)
            self._count = 0
            return
        depth, owner, picture, self._count = self._kept
        self._depth[:], self._owner[:], self._picture[:] = depth, owner, picture

    def keep(self, background: tuple[int, int, int] = (0, 0, 0)) -> None:
        """Let what is drawn now be in all further pictures: `begin` returns to it, and it is shaded once.

        It has the same noise in all of them, so this is for a canvas without noise.
        """
        self._kept = self._depth.copy(), self._owner.copy(), self.picture(background), self._count

    def draw(self, mesh: Mesh, view: Floats) -> None:
        """Draw a mesh; `view` (4 x 4) leads from its frame to the camera's: x right, y down, z forward."""
        most = self._count + 2 * len(mesh.corners)  # the near plane makes two of one
        if most > len(self._planes):
            self._planes = np.concatenate([self._planes, np.zeros((most, PLANES))])
        self._count = _draw(
            mesh.corners, mesh.uv, mesh.light, mesh.tint, mesh.texture, np.ascontiguousarray(view, np.float64),
            self.lens.focal, self._atlas.table, self._planes, self._count, self._depth, self._owner,
        )  # fmt: skip

    def picture(self, background: tuple[int, int, int] = (0, 0, 0)) -> Picture:
        """Return the picture, shape (height, width, 3); each has noise of its own."""
        start = int(self._dice.integers(0, len(self._grain)))
        _shade(
            self._planes, self._owner, self._atlas.table, self._atlas.texels, np.array(background, np.float64),
            self._grain, start, self._kept[3] if self._kept else -1, self._picture,
        )  # fmt: skip
        return self._picture.copy()

    def depth(self) -> NDArray[np.float64]:
        """Return the distance along the optical axis (m), infinite where nothing was drawn."""
        with np.errstate(divide="ignore"):
            return np.asarray(1.0 / self._depth.astype(np.float64))


def looking(place: Floats, at: Floats, up: tuple[float, float, float] = (0.0, 0.0, 1.0)) -> Floats:
    """Return the view (4 x 4) from world to a camera at `place` that looks to `at` (m)."""
    forward = np.subtract(at, place) / np.linalg.norm(np.subtract(at, place))
    right = np.cross(forward, up)
    right /= np.linalg.norm(right)
    view = np.eye(4)
    view[:3, :3] = np.stack([right, np.cross(forward, right), forward])
    view[:3, 3] = -view[:3, :3] @ np.asarray(place, np.float64)
    return view


@njit(cache=True, nogil=True)
def _draw(corners, uv, light, tint, texture, view, focal, table, planes, count, depth, owner):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    """Draw triangles in camera coordinates, cut at the near plane; return the number of planes in use."""
    points = np.empty((3, 6))  # x, y, z, u, v, light
    cut = np.empty((4, 6))
    for t in range(corners.shape[0]):
        infront = 0
        for k in range(3):
            for i in range(3):
                points[k, i] = (
                    view[i, 0] * corners[t, k, 0] + view[i, 1] * corners[t, k, 1]
                    + view[i, 2] * corners[t, k, 2] + view[i, 3]
                )  # fmt: skip
            points[k, 3] = uv[t, k, 0]
            points[k, 4] = uv[t, k, 1]
            points[k, 5] = light[t, k]
            infront += points[k, 2] > NEAR_M
        if infront == 0 or _turned_away(points):
            continue
        number = 3
        if infront == 3:
            cut[:3] = points
        else:
            number = _cut(points, cut)
        for k in range(1, number - 1):
            if _plane(cut, k, focal, depth.shape, texture[t], table, tint[t], planes[count]):
                _fill(cut, k, focal, planes[count], count, depth, owner)
                count += 1
    return count


@njit(cache=True, nogil=True)
def _turned_away(p):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    """Return whether the triangle's back is to the camera, which is at the origin."""
    ax, ay, az = p[1, 0] - p[0, 0], p[1, 1] - p[0, 1], p[1, 2] - p[0, 2]
    bx, by, bz = p[2, 0] - p[0, 0], p[2, 1] - p[0, 1], p[2, 2] - p[0, 2]
    x, y, z = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    return x * p[0, 0] + y * p[0, 1] + z * p[0, 2] >= 0.0


@njit(cache=True, nogil=True)
def _cut(points, out):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    """Cut a triangle at the near plane; return the number of corners of the part in front of it."""
    number = 0
    for k in range(3):
        a, b = points[k], points[(k + 1) % 3]
        if a[2] > NEAR_M:
            out[number] = a
            number += 1
        if (a[2] > NEAR_M) != (b[2] > NEAR_M):
            share = (NEAR_M - a[2]) / (b[2] - a[2])
            for i in range(6):
                out[number, i] = a[i] + share * (b[i] - a[i])
            number += 1
    return number


@njit(cache=True, nogil=True)
def _plane(p, k, focal, shape, texture, table, tint, out):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    """Write how 1/z, u/z, v/z and light/z grow over the picture; return False for a triangle without area."""
    cx, cy = shape[1] / 2, shape[0] / 2
    w0, w1, w2 = 1 / p[0, 2], 1 / p[k, 2], 1 / p[k + 1, 2]
    x0, y0 = cx + focal * p[0, 0] * w0, cy + focal * p[0, 1] * w0
    x1, y1 = cx + focal * p[k, 0] * w1 - x0, cy + focal * p[k, 1] * w1 - y0
    x2, y2 = cx + focal * p[k + 1, 0] * w2 - x0, cy + focal * p[k + 1, 1] * w2 - y0
    area = x1 * y2 - x2 * y1
    if abs(area) < 1e-9:
        return False
    for i in range(4):
        if i == 0:
            a, b, c = w0, w1, w2
        else:
            a, b, c = p[0, 2 + i] * w0, p[k, 2 + i] * w1, p[k + 1, 2 + i] * w2
        dx = ((b - a) * y2 - (c - a) * y1) / area
        dy = ((c - a) * x1 - (b - a) * x2) / area
        out[3 * i], out[3 * i + 1], out[3 * i + 2] = dx, dy, a - dx * x0 - dy * y0
    out[12] = texture
    out[13] = 0.0
    if texture >= 0:  # texels per pixel, as an area, are this times z cubed: the Jacobian of a homography
        det = (
            out[3] * (out[7] * out[2] - out[8] * out[1])
            - out[4] * (out[6] * out[2] - out[8] * out[0])
            + out[5] * (out[6] * out[1] - out[7] * out[0])
        )
        out[13] = abs(det) * table[texture, 1] * table[texture, 2]
    out[14], out[15], out[16] = tint[0], tint[1], tint[2]
    return True


@njit(cache=True, nogil=True)
def _fill(p, k, focal, plane, number, depth, owner):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    """Write the triangle's number into the pixels where it is the nearest so far, row by row."""
    height, width = depth.shape
    xs, ys = np.empty(3), np.empty(3)
    for j, corner in enumerate((0, k, k + 1)):
        xs[j] = width / 2 + focal * p[corner, 0] / p[corner, 2]
        ys[j] = height / 2 + focal * p[corner, 1] / p[corner, 2]
    first = max(0, int(np.ceil(min(max(ys.min(), -1.0), height) - 0.5)))
    last = min(height - 1, int(np.floor(max(min(ys.max(), height + 1.0), -1.0) - 0.5)))
    for row in range(first, last + 1):
        y, left, right = row + 0.5, 1e30, -1e30
        for j in range(3):
            ya, yb = ys[j], ys[(j + 1) % 3]
            if (ya <= y) != (yb <= y):
                x = xs[j] + (y - ya) / (yb - ya) * (xs[(j + 1) % 3] - xs[j])
                left, right = min(left, x), max(right, x)
        if right < 0.0 or left > width:
            continue
        begin = max(0, int(np.ceil(max(left, 0.0) - 0.5 - SEAM_PX)))
        end = min(width - 1, int(np.floor(min(right, width) - 0.5 + SEAM_PX)))
        w = plane[1] * y + plane[2] + plane[0] * (begin + 0.5)
        for column in range(begin, end + 1):
            if w > depth[row, column]:
                depth[row, column] = w
                owner[row, column] = number
            w += plane[0]


@njit(cache=True, nogil=True, fastmath=True)
def _shade(planes, owner, table, texels, background, grain, start, first, out):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    """Write the colour of each pixel, from triangle `first` on: tint, light and texture of its triangle, and noise."""
    height, width = owner.shape
    colour, last = np.empty(3), grain.shape[0] - 1  # a power of two
    for row in range(height):
        for column in range(width):
            number = owner[row, column]
            if number < first:
                continue
            if number < 0:
                for c in range(3):
                    colour[c] = background[c]
            else:
                p, x, y = planes[number], column + 0.5, row + 0.5
                z = 1 / (p[0] * x + p[1] * y + p[2])
                lit = (p[9] * x + p[10] * y + p[11]) * z
                texture = int(p[12])
                if texture < 0:
                    for c in range(3):
                        colour[c] = p[14 + c] * lit
                else:
                    u, v = (p[3] * x + p[4] * y + p[5]) * z, (p[6] * x + p[7] * y + p[8]) * z
                    _read(table, texels, texture, u, v, p[13] * z * z * z, colour)
                    lit /= 255.0
                    for c in range(3):
                        colour[c] *= p[14 + c] * lit
            noise = grain[(start + row * width + column) & last] + 0.5
            for c in range(3):
                out[row, column, c] = int(min(max(colour[c] + noise, 0.0), 255.0))


@njit(cache=True, nogil=True, fastmath=True)
def _read(table, texels, texture, u, v, area, colour):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    """Read a texture between its four nearest texels, at the level where a texel is about a pixel; it repeats."""
    at, width, height, levels = table[texture, 0], table[texture, 1], table[texture, 2], table[texture, 3]
    while area > 1.6 and levels > 1:
        at += width * height * 3
        width, height = max(1, width >> 1), max(1, height >> 1)
        area *= 0.25
        levels -= 1
    x, y = (u - np.floor(u)) * width + 0.5, (v - np.floor(v)) * height + 0.5  # a texel right and down of it: above 0
    right, low = int(x), int(y)
    fx, fy = x - right, y - low
    x0, y0, x1, y1 = (right - 1) & (width - 1), (low - 1) & (height - 1), right & (width - 1), low & (height - 1)
    a, b = at + 3 * (y0 * width + x0), at + 3 * (y0 * width + x1)
    c, d = at + 3 * (y1 * width + x0), at + 3 * (y1 * width + x1)
    p, q, r, s = (1 - fx) * (1 - fy), fx * (1 - fy), (1 - fx) * fy, fx * fy
    for i in range(3):
        colour[i] = texels[a + i] * p + texels[b + i] * q + texels[c + i] * r + texels[d + i] * s
