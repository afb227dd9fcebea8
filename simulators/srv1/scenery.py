"""The scene that the cameras see: the lit floor, walls and ceiling, showcases, exhibits, and the rover."""

from math import pi

import numpy as np

from robots.kit.drivers.srv1.hall import Case, Exhibit, Hall
from simulators.common.mesh import WHITE, Colour, Mesh, box, joined, lid, placed, prism, quad, turned
from simulators.common.texture import Atlas
from simulators.srv1 import drawings, paintings
from simulators.srv1.exhibits import BRASS, alone, inside
from simulators.srv1.solids import Floats, ball, sheet

CELL_M = 0.25  # of the grid on which light is computed
BASE_M = 0.34  # height of a showcase's base
POST_M = 0.018
PICTURE_M = (1.6, 1.2)
PICTURE_Z = 1.42  # of a painting's middle
SKIRTING_M = 0.12
SHADE_M = 0.22  # the floor is darker up to this distance from a thing that stands on it
SPOT_M = 1.5


class Surfaces:
    """The textures that several things share."""

    def __init__(self, atlas: Atlas) -> None:
        self.atlas = atlas
        self.wood = atlas.add(drawings.wood())
        self.door = atlas.add(drawings.wood((128, 84, 48)))
        self.black = atlas.add(drawings.black_glass())


def _spots(where: Hall, places: Floats) -> Floats:
    """Return what the lamps over showcases and exhibits add at places (n, 3) of floor and walls."""
    lamps = np.array([thing.at for thing in where.things])
    away = ((places[:, None, :2] - lamps) ** 2).sum(-1)
    return np.asarray(0.22 * np.exp(-away / SPOT_M**2).sum(1))


def _floor_light(where: Hall, places: Floats) -> Floats:
    """Return the floor's light: the lamps', less beside walls and everything that stands there."""
    x, y = places[:, 0], places[:, 1]
    walls = np.minimum.reduce([x, where.width - x, y, where.depth - y])
    shade = 0.30 * np.exp(-walls / (2 * SHADE_M))
    near = np.min([_away(thing, x, y) for thing in where.things], axis=0)
    return np.asarray(0.74 + _spots(where, places) - shade - 0.42 * np.exp(-near / SHADE_M))


def _away(thing: Case | Exhibit, x: Floats, y: Floats) -> Floats:
    """Return how far places (n,) are from the surface of what stands there (m), as its own `distance` does."""
    dx, dy = x - thing.at[0], y - thing.at[1]
    if isinstance(thing, Exhibit):
        return np.asarray(np.maximum(np.hypot(dx, dy) - thing.radius, 0.0))
    return np.hypot(np.maximum(np.abs(dx) - thing.half[0], 0.0), np.maximum(np.abs(dy) - thing.half[1], 0.0))


def _wall_light(where: Hall, places: Floats) -> Floats:
    z = places[:, 2] / where.high
    return np.asarray(0.70 + 0.34 * np.sin(np.clip(z, 0, 1) * pi) + 0.5 * _spots(where, places))


def _cells(length: float) -> int:
    return max(1, round(length / CELL_M))


def _sides(where: Hall) -> list[tuple[tuple[float, float], tuple[float, float], float]]:
    """Return where each wall begins on its left as seen from inside, its direction, and its length."""
    w, d = where.width, where.depth
    return [((w, 0), (-1, 0), w), ((w, d), (0, -1), d), ((0, d), (1, 0), w), ((0, 0), (0, 1), d)]


def room(where: Hall, surfaces: Surfaces) -> Mesh:
    """Return floor, walls with their paintings and a door, and ceiling."""
    atlas = surfaces.atlas
    w, d, h = where.width, where.depth, where.high
    floor, plaster, roof = (atlas.add(p) for p in (drawings.floor(), drawings.plaster(), drawings.ceiling()))
    cells = 2 * _cells(w), 2 * _cells(d)
    parts = [
        sheet((0, 0, 0), (w, 0, 0), (0, d, 0), cells, floor, (w / 2, d / 2), lambda p: _floor_light(where, p)),
        sheet((w, 0, h), (-w, 0, 0), (0, d, 0), (6, 4), roof, (w / 4, d / 4), lambda p: np.full(len(p), 0.86)),
    ]
    number = 0
    for (x, y), (a, b), length in _sides(where):
        inwards = np.array([b, -a])
        parts.append(
            sheet((x, y, 0), (a * length, b * length, 0), (0, 0, h), (_cells(length), _cells(h)), plaster,
                  (length * 2, h * 2), lambda p: _wall_light(where, p))
        )  # fmt: skip
        parts.append(_band(x, y, a, b, length, inwards, 0.0, SKIRTING_M, (70, 50, 38)))
        parts.append(_band(x, y, a, b, length, inwards, 0.55, 0.59, (196, 186, 160)))
        parts.append(_band(x, y, a, b, length, inwards, h - 0.16, h, (206, 198, 178)))
        for at in _hung(length):
            middle = np.array([x, y]) + np.array([a, b]) * at
            if not _behind(where, middle):
                picture = atlas.add(paintings.painting(number))
                parts.append(_painting(middle, np.array([a, b]), inwards, picture))
                number += 1
    parts.append(_door(where, surfaces))
    return joined(*parts)


def _hung(length: float) -> list[float]:
    count = int(length // 2.6)
    return [(i + 0.5) * length / count for i in range(count)]


def _behind(where: Hall, middle: Floats) -> bool:
    """Return whether the door is there."""
    return bool(np.hypot(*(middle - (where.home[0], 0.0))) < 1.2)


def _band(x: float, y: float, a: float, b: float, length: float, inwards: Floats, low: float, high: float,
          tint: Colour) -> Mesh:  # fmt: skip
    """Return a moulding along a wall."""
    begin = np.array([x, y]) + inwards * 0.02
    end = begin + np.array([a, b]) * length
    face = quad([(*begin, low), (*end, low), (*end, high), (*begin, high)], tint, light=0.86)
    top = quad([(*begin, high), (*end, high), (*(end - inwards * 0.02), high), (*(begin - inwards * 0.02), high)], tint,
               light=1.0)  # fmt: skip
    return joined(face, top)


def _painting(middle: Floats, along: Floats, inwards: Floats, picture: int) -> Mesh:
    """Return a painting in its frame, with a lamp's light on it."""

    def face(off: float, wide: float, high: float, tint: Colour, texture: int, light: float) -> Mesh:
        left, right = middle - along * wide / 2 + inwards * off, middle + along * wide / 2 + inwards * off
        low, top = PICTURE_Z - high / 2, PICTURE_Z + high / 2
        return quad([(*left, low), (*right, low), (*right, top), (*left, top)], tint, texture, light=light)

    wide, high = PICTURE_M
    return joined(
        face(0.012, wide + 0.2, high + 0.2, (124, 88, 38), -1, 1.0),
        face(0.018, wide + 0.14, high + 0.14, BRASS, -1, 1.0),
        face(0.024, wide + 0.03, high + 0.03, (60, 44, 30), -1, 1.0),
        face(0.03, wide, high, WHITE, picture, 1.06),
    )


def _door(where: Hall, surfaces: Surfaces) -> Mesh:
    """Return the door near the rover's home, with the sign over it."""
    x = where.home[0]
    sign = surfaces.atlas.add(drawings.exit_sign())

    def face(left: float, right: float, low: float, high: float, off: float, tint: Colour, texture: int = -1) -> Mesh:
        # seen from inside, the wall at y = 0 has +x on its left
        return quad([(x + left, off, low), (x - right, off, low), (x - right, off, high), (x + left, off, high)], tint,
                    texture, [[0, 2], [1, 2], [1, 0], [0, 0]] if texture == surfaces.door else None, 0.96)  # fmt: skip

    return joined(
        face(0.86, 0.86, 0, 2.28, 0.024, (74, 52, 36)), face(0.78, 0.01, 0, 2.2, 0.03, WHITE, surfaces.door),
        face(-0.01, 0.78, 0, 2.2, 0.03, WHITE, surfaces.door), face(0.1, -0.06, 0.95, 1.15, 0.04, BRASS),
        face(-0.06, 0.1, 0.95, 1.15, 0.04, BRASS), face(0.35, 0.35, 2.36, 2.54, 0.035, WHITE, sign),
    )  # fmt: skip


def case(one: Case, surfaces: Surfaces) -> Mesh:
    """Return a showcase where the description has it: wood, a plate with its name, glass between posts, its things."""
    turned_by = 0.0 if one.half[0] >= one.half[1] else pi / 2
    wide, deep, high = max(one.half), min(one.half), one.high
    atlas = surfaces.atlas
    parts = [box((-wide + 0.03, -deep + 0.03, 0), (wide - 0.03, deep - 0.03, 0.06), (36, 30, 26)),
             box((-wide, -deep, 0.06), (wide, deep, BASE_M), WHITE, surfaces.wood)]  # fmt: skip
    plate, half = atlas.add(drawings.plate(one.name)), min(0.3, wide - 0.05)
    for side in (-1, 1):
        left, right, y, top = side * half, -side * half, side * (deep + 0.004), 0.15 + half / 2
        parts.append(
            quad([(left, y, 0.15), (right, y, 0.15), (right, y, top), (left, y, top)], WHITE, plate, light=1.0)
        )
    if one.black:
        outline = np.array([(-wide, -deep), (wide, -deep), (wide, deep), (-wide, deep)]) * 0.99
        parts += [prism(outline, BASE_M, high, WHITE, surfaces.black, top=False), lid(outline, BASE_M, (30, 30, 34)),
                  lid(outline, high, (30, 30, 34))]  # fmt: skip
    else:
        parts += [_vitrine(wide, deep, high), inside(one, atlas).lit(1.08).in_frame(placed(0, 0, BASE_M + 0.045))]
    return joined(*parts).in_frame(placed(*one.at, 0.0, turned_by))


def _vitrine(wide: float, deep: float, high: float) -> Mesh:
    """Return the white floor of a showcase, its brass posts, a frame with lamps, and what shines in its glass."""
    low, top, brass, n = BASE_M, high - 0.05, (188, 150, 82), POST_M
    outline = np.array([(-wide, -deep), (wide, -deep), (wide, deep), (-wide, deep)])
    parts = [box((-wide + 0.01, -deep + 0.01, low), (wide - 0.01, deep - 0.01, low + 0.045), (244, 240, 230)),
             prism(outline, top, high, (70, 52, 40), top=False),  # above it is glass
             quad([(-wide, deep, top), (wide, deep, top), (wide, -deep, top), (-wide, -deep, top)], (255, 250, 232),
                  light=1.1), prism(outline * 1.004, low - 0.012, low + 0.012, brass)]  # fmt: skip
    for x in (-wide, wide - n):
        for y in (-deep, deep - n):
            parts.append(box((x, y, low), (x + n, y + n, top), brass))
    for side in (-1, 1):
        for at, thick in ((0.52, 0.016), (0.58, 0.006)):
            left, right, y = side * wide * at, side * (wide * at - thick), side * deep
            lean = -side * 0.16
            parts.append(quad([(left + lean, y, top - 0.34), (right + lean, y, top - 0.34), (right, y, top - 0.04),
                               (left, y, top - 0.04)], (222, 232, 234), light=1.0))  # fmt: skip
    return joined(*parts)


def exhibit(one: Exhibit, surfaces: Surfaces) -> Mesh:
    """Return an exhibit where the description has it, with a plate at its foot."""
    return alone(one, surfaces.atlas).in_frame(placed(*one.at, 0.0))


def rover() -> Mesh:
    """Return the rover as others see it: a hull on four wheels, its camera, its sonar, and a lamp."""
    dark, hull = (34, 34, 38), (60, 96, 140)
    parts = [
        box((-0.14, -0.08, 0.03), (0.14, 0.08, 0.11), hull),
        box((-0.1, -0.06, 0.11), (0.06, 0.06, 0.125), (30, 110, 60)),
    ]
    for x in (-0.085, 0.085):
        for side in (-1, 1):
            wheel = turned([(0.0, -0.02), (0.045, -0.02), (0.045, 0.02), (0.0, 0.02)], dark, 14)
            axle = np.array([[1, 0, 0, x], [0, 0, -1, side * 0.1], [0, 1, 0, 0.045], [0, 0, 0, 1]], float)
            parts.append(wheel.in_frame(axle))
            parts.append(ball((x, side * 0.118, 0.045), 0.016, (200, 200, 204), sides=8))
    parts.append(box((0.07, -0.03, 0.11), (0.115, 0.03, 0.155), (220, 222, 226)))
    parts.append(ball((0.115, 0, 0.14), 0.014, (16, 16, 20), sides=8))
    for side in (-1, 1):
        parts.append(ball((0.138, side * 0.03, 0.10), 0.018, (214, 170, 70), sides=8))
    parts.append(box((-0.03, -0.012, 0.126), (0.03, 0.012, 0.128), (240, 240, 240)))
    parts.append(ball((-0.1, 0, 0.13), 0.016, (240, 90, 50), sides=8))
    return joined(*parts)
