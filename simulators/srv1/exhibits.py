"""Exhibits in the showcases and free-standing ones: each as a mesh around (0, 0), on the height z = 0."""

from collections.abc import Callable
from math import cos, pi, sin

import numpy as np

from robots.kit.drivers.srv1.hall import Case, Exhibit
from simulators.common.mesh import WHITE, Colour, Mesh, box, joined, placed, quad, turned
from simulators.common.texture import Atlas
from simulators.srv1 import drawings, paintings
from simulators.srv1.solids import Place, ball, bone, bones, disc

STONE: Colour = (222, 216, 204)
IVORY: Colour = (226, 212, 176)
BRASS: Colour = drawings.BRASS


def _ammonites(atlas: Atlas, width: float, deep: float) -> Mesh:
    """Return fossils on stands, the largest in the middle, seen from both sides."""
    texture, parts = atlas.add(drawings.spiral()), []
    for x, r in ((-0.62, 0.10), (-0.33, 0.15), (0.0, 0.22), (0.34, 0.14), (0.63, 0.11)):
        at = x * width * 0.8
        parts.append(box((at - 0.05, -0.04, 0), (at + 0.05, 0.04, 0.06), STONE))
        for side in (-1, 1):
            parts.append(disc((at, side * 0.005, 0.05 + r), (0, side, 0.12), r, texture, 0.03, (120, 94, 66)))
    return joined(*parts)


def _board(texture: int, width: float, high: float, deep: float = 0.14) -> Mesh:
    """Return a picture board with a face to both sides that leans back a little."""
    faces = []
    for side in (-1, 1):
        corners = [(side * width, side * deep, 0.03), (-side * width, side * deep, 0.03),
                   (-side * width, side * 0.02, high), (side * width, side * 0.02, high)]  # fmt: skip
        faces.append(quad(corners, WHITE, texture, light=1.02))
        foot, out = side * width * 1.02, side * deep * 0.98
        faces.append(quad([(foot, out, 0.0), (-foot, out, 0.0), *corners[1::-1]], (92, 62, 40)))
    return joined(*faces)


def _beetles(atlas: Atlas, width: float, deep: float) -> Mesh:
    return _board(atlas.add(drawings.collection()), width * 0.86, 0.62)


def _coins(atlas: Atlas, width: float, deep: float) -> Mesh:
    return _board(atlas.add(drawings.coins()), width * 0.9, 0.5, 0.11)


def _tortoise(size: float, shell: Colour) -> Mesh:
    skin: Colour = (132, 140, 84)
    profile = [(0.5, 0.12), (0.47, 0.3), (0.33, 0.46), (0.14, 0.54), (0.0, 0.56)]
    back = turned([(r * size, h * size) for r, h in profile], shell, 12).in_frame(np.diag([1.25, 1.0, 1.0, 1.0]))
    legs = [
        ball((x * size, y * size, 0.09 * size), 0.13 * size, skin, sides=8)
        for x, y in ((0.4, 0.36), (0.4, -0.36), (-0.4, 0.36), (-0.4, -0.36))
    ]
    head = ball((0.78 * size, 0, 0.28 * size), 0.15 * size, skin, sides=10)
    neck = bone((0.5 * size, 0, 0.2 * size), (0.75 * size, 0, 0.27 * size), 0.09 * size, skin)
    eyes = [
        ball((0.88 * size, side * 0.09 * size, 0.33 * size), 0.03 * size, (14, 14, 12), sides=6) for side in (-1, 1)
    ]
    return joined(back, *legs, neck, head, *eyes)


def _reptiles(atlas: Atlas, width: float, deep: float) -> Mesh:
    """Return two tortoises, a snake and a lizard on sand, between stones."""
    sand = box((-width * 0.94, -deep * 0.88, 0), (width * 0.94, deep * 0.88, 0.03), (216, 190, 140))
    coil: list[Place] = [
        ((0.2 - 0.018 * t) * cos(t), (0.2 - 0.018 * t) * sin(t), 0.05 + 0.012 * t) for t in np.linspace(0, 9, 19)
    ]
    snake = joined(bones(coil, 0.028, (190, 120, 50)), ball(coil[-1], 0.045, (204, 130, 56), sides=8))
    spine: list[Place] = [
        (0.22, 0.0, 0.07),
        (0.1, 0.02, 0.08),
        (0.0, 0.0, 0.08),
        (-0.12, -0.03, 0.06),
        (-0.26, 0.03, 0.04),
    ]
    green: Colour = (70, 150, 90)
    lizard = joined(
        bones(spine, 0.04, green, 0.8),
        ball((0.24, 0, 0.08), 0.05, green, sides=8, stretch=(1.4, 1, 0.8)),
        *(bone((x, 0, 0.07), (x + 0.03, side * 0.1, 0.03), 0.014, green) for x in (0.14, -0.05) for side in (-1, 1)),
    )
    stones = [
        ball((x, y, 0.03), r, (150 - 8 * i, 142, 130), sides=8, stretch=(1.3, 1.0, 0.8))
        for i, (x, y, r) in enumerate(((-0.66, 0.18, 0.1), (0.05, 0.26, 0.12), (0.68, -0.2, 0.09)))
    ]
    return joined(
        sand, *stones, _tortoise(0.2, (112, 92, 52)).in_frame(placed(-0.5, -0.08, 0.03, -0.5)),
        _tortoise(0.13, (92, 84, 40)).in_frame(placed(-0.2, 0.14, 0.03, 2.4)),
        snake.in_frame(placed(0.13, -0.08, 0.02)),
        lizard.in_frame(placed(0.52, 0.06, 0.02, 0.6)),
    )  # fmt: skip


def _minerals(atlas: Atlas, width: float, deep: float) -> Mesh:
    """Return crystals in druses."""
    dice = np.random.default_rng(21)
    inks: tuple[Colour, ...] = ((150, 90, 190), (236, 236, 244), (90, 190, 130), (236, 170, 60), (90, 150, 220))
    parts = []
    for x, ink in zip(np.linspace(-0.74, 0.74, 5), inks, strict=True):
        at = float(x) * width
        parts.append(ball((at, 0, 0), 0.11, (108, 100, 96), sides=10, stretch=(1.0, 1.1, 0.5)))
        for _ in range(9):
            angle, out = dice.uniform(0, 2 * pi), dice.uniform(0.0, 0.08)
            r, high = dice.uniform(0.016, 0.034), dice.uniform(0.14, 0.42) * (1.2 - 6 * out)
            tone: Colour = tuple(float(v * dice.uniform(0.78, 1.05)) for v in ink)  # type: ignore[assignment]
            crystal = turned([(r, 0), (r * 0.92, high * 0.75), (0, high)], tone, 6)
            lean = np.eye(4)
            lean[:3, 2] = np.array([cos(angle) * out * 4, sin(angle) * out * 4, 1.0])
            parts.append(crystal.in_frame(placed(at + out * cos(angle), out * sin(angle), 0.03) @ lean))
    return joined(*parts)


def _meteorite(atlas: Atlas, width: float, deep: float) -> Mesh:
    return box((-0.01, -0.01, 0), (0.01, 0.01, 0.01), (20, 20, 24))  # nobody sees through black glass


INSIDE: dict[str, Callable[[Atlas, float, float], Mesh]] = {
    "Ammonites": _ammonites, "Beetles": _beetles, "Reptiles": _reptiles, "Minerals": _minerals, "Coins": _coins,
    "Meteorite": _meteorite,
}  # fmt: skip


def inside(case: Case, atlas: Atlas) -> Mesh:
    """Return the contents of a showcase, whose long side is along x; crystals if its name is not known."""
    wide, deep = max(case.half), min(case.half)
    return INSIDE.get(case.name, _minerals)(atlas, wide - 0.06, deep - 0.05)


def _globe(atlas: Atlas, exhibit: Exhibit) -> Mesh:
    r, high = exhibit.radius, exhibit.high
    wood: Colour = (112, 70, 44)
    foot = turned([(r, 0), (r, 0.16), (r * 0.9, 0.2), (0.16, 0.26), (0.12, 0.5), (0, 0.5)], wood, 20)
    ring = turned([(r * 1.0, high - r - 0.02), (r * 1.0, high - r + 0.02), (r * 0.96, high - r + 0.02)], BRASS, 28)
    return joined(foot, ball((0, 0, high - r * 0.95), r * 0.95, WHITE, atlas.add(paintings.globe()), 24), ring)


def _vase(atlas: Atlas, exhibit: Exhibit) -> Mesh:
    r, half = exhibit.radius, exhibit.high / 2
    column = turned([(r, 0), (r, 0.1), (r * 0.8, 0.14), (r * 0.78, half - 0.1), (r, half - 0.05), (r, half), (0, half)],
                    STONE, 20)  # fmt: skip
    parts, blue, white = [column], (44, 84, 160), (238, 238, 232)
    rows = [(0.10, 0.0), (0.17, 0.12), (0.24, 0.27), (0.25, 0.38), (0.2, 0.5), (0.1, 0.58), (0.08, 0.63), (0.13, 0.69)]
    for i in range(len(rows) - 1):
        band = [(a * r / 0.3, half + h * half / 0.7) for a, h in rows[i : i + 2]]
        parts.append(turned(band, blue if i in (1, 3, 5) else white, 20))
    return joined(*parts)


def _skeleton(atlas: Atlas, exhibit: Exhibit) -> Mesh:
    """Return a small dinosaur on two legs, on a round base."""
    r = exhibit.radius
    base = turned([(r, 0), (r, 0.24), (r - 0.03, 0.27), (0, 0.27)], (96, 62, 42), 20)
    hip, chest, head = (-0.05, 0.0, 0.98), (0.14, 0.0, 1.3), (0.2, 0.0, 1.72)
    parts = [base, bone((-0.05, 0, 0.27), (-0.05, 0, 0.95), 0.012, (60, 60, 64))]
    parts.append(bones([hip, (0.04, 0, 1.14), chest, (0.19, 0, 1.46), (0.16, 0, 1.6), head], 0.03, IVORY, 0.95))
    tail: list[Place] = [
        (hip[0] - 0.3 * t, 0.12 * sin(3 * t), hip[2] - 0.44 * t + 0.12 * t * t) for t in np.linspace(0, 1, 8)
    ]
    parts.append(bones(tail, 0.028, IVORY, 0.8))
    for along in np.linspace(0.15, 1.0, 7):  # ribs
        x, z = hip[0] + along * (chest[0] - hip[0]), hip[2] + along * (chest[2] - hip[2])
        deep = 0.10 + 0.10 * sin(pi * (0.2 + 0.7 * along))
        for side in (-1, 1):
            parts.append(bones([
                (x, 0, z), (x + 0.3 * deep, side * deep * 0.75, z - 0.25 * deep),
                (x + 0.75 * deep, side * deep * 0.7, z - 0.75 * deep), (x + 0.95 * deep, side * 0.02, z - deep),
            ], 0.012, IVORY, 0.9))  # fmt: skip
    for side in (-1, 1):
        leg: list[Place] = [(hip[0], side * 0.06, hip[2]), (hip[0] + 0.16, side * 0.13, 0.72),
                            (hip[0] - 0.06, side * 0.13, 0.48), (hip[0] + 0.02, side * 0.13, 0.3)]  # fmt: skip
        parts.append(bones(leg, 0.034, IVORY, 0.85))
        for toe in (-0.05, 0.0, 0.05):
            parts.append(bone(leg[-1], (hip[0] + 0.18, side * 0.13 + toe, 0.28), 0.016, IVORY, 0.5))
        arm: list[Place] = [
            (chest[0], side * 0.12, 1.26),
            (chest[0] + 0.1, side * 0.15, 1.12),
            (chest[0] + 0.2, side * 0.11, 1.16),
        ]
        parts.append(bones(arm, 0.016, IVORY, 0.85))
        parts.append(ball((0.26, side * 0.05, 1.75), 0.026, (30, 24, 20), sides=8))
    parts.append(ball((0.22, 0, 1.74), 0.085, IVORY, sides=12, stretch=(1.2, 0.75, 0.85)))
    parts.append(bone((0.25, 0, 1.73), (0.385, 0, 1.69), 0.055, IVORY, 0.5, 8))
    parts.append(bone((0.2, 0, 1.66), (0.36, 0, 1.63), 0.032, IVORY, 0.6, 8))
    return joined(*parts)


ALONE: dict[str, Callable[[Atlas, Exhibit], Mesh]] = {"Globe": _globe, "Vase": _vase, "Skeleton": _skeleton}


def alone(exhibit: Exhibit, atlas: Atlas) -> Mesh:
    """Return an exhibit that stands free; a vase on a column if its name is not known."""
    return ALONE.get(exhibit.name, _vase)(atlas, exhibit)
