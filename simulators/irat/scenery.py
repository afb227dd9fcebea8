"""The scene that the cameras see: the maze on its board, objects around it, the hall, the dock and the robot."""

from itertools import pairwise

import numpy as np

from simulators.common.mesh import WHITE, Colour, Mesh, box, joined, lid, placed, prism, quad, turned
from simulators.common.texture import Atlas
from simulators.irat import drawings, hall
from simulators.irat.dock import GUIDE_HIGH_M, GUIDES, SPRINGS, STOP_HIGH_M, STOP_M
from simulators.irat.maze import BOARD, COLUMN, DOCK, HEIGHT_M, OPEN_FLOOR, WALL_HIGH_M, WIDTH_M, Wall, walls

HALL_M, HIGH_M, TABLE_M = 6.4, 3.2, 0.75
STICKER_M, LEAST_STICKER_M, STICKERS, EVERY_M = 0.10, 0.05, 40, 0.24
MIDDLE = np.array([WIDTH_M / 2, HEIGHT_M / 2])
STAY_OFF_M = 0.001
THINGS: tuple[tuple[str, float, float, float, Colour], ...] = (  # kind, x, y, height (m), colour; none in a corridor
    ("tin", 0.47, 1.46, 0.30, (220, 70, 60)), ("blocks", 0.49, 0.82, 0.26, (70, 150, 220)),
    ("cone", 0.66, 0.53, 0.30, (250, 150, 40)), ("tin", 0.83, 0.53, 0.22, (90, 180, 100)),
    ("bottle", 0.49, 1.12, 0.34, (60, 140, 120)), ("blocks", 0.75, 1.75, 0.24, (240, 200, 70)),
    ("bottle", 0.985, 1.12, 0.32, (170, 90, 190)), ("cone", 1.47, 1.33, 0.28, (230, 70, 110)),
    ("tin", 1.66, 1.12, 0.24, (70, 110, 200)),
    ("tin", 2.03, 1.80, 0.34, (240, 220, 120)), ("bottle", 1.98, 0.62, 0.30, (220, 90, 80)),
    ("cone", 0.07, 0.10, 0.32, (90, 190, 220)), ("blocks", 1.52, 0.16, 0.26, (160, 200, 90)),
    ("tin", 1.25, 0.10, 0.28, (190, 110, 60)), ("bottle", 0.46, 1.78, 0.36, (200, 170, 60)),
)  # fmt: skip


def maze(atlas: Atlas) -> Mesh:
    """Return walls of foam with posters."""
    foam = atlas.add(drawings.foam())
    posters = [atlas.add(drawings.sticker(n)) for n in range(STICKERS)]
    parts, hung, bare = [], 0, EVERY_M
    for wall in (wall for row in walls() for wall in row):
        parts.append(_wall(wall, foam))
        side = min(STICKER_M, 0.8 * wall.length)
        at = max(side / 2, EVERY_M - bare)
        while side >= LEAST_STICKER_M and at <= wall.length - side / 2:
            parts.append(_poster(wall, at, side, posters[hung * 11 % STICKERS]))
            hung, bare, at = hung + 1, -at, at + EVERY_M
        bare += wall.length
    return joined(*parts)


def _wall(wall: Wall, texture: int) -> Mesh:
    a, b, c, d = wall.begin, wall.end, wall.back_end, wall.back_begin
    span, high = [[0, 2], [wall.length * 12, 2], [wall.length * 12, 0], [0, 0]], WALL_HIGH_M
    face = quad([(*b, 0), (*a, 0), (*a, high), (*b, high)], WHITE, texture, span, darker=0.62)
    back = quad([(*d, 0), (*c, 0), (*c, high), (*d, high)], WHITE, texture, span, darker=0.62)
    return joined(face, back, quad([(*d, high), (*c, high), (*b, high), (*a, high)], WHITE, texture, span))


def _poster(wall: Wall, at: float, side: float, texture: int, off: float = STAY_OFF_M) -> Mesh:
    """Return a poster on a wall's face, its middle `at` m from the beginning."""
    along = np.subtract(wall.end, wall.begin) / wall.length
    middle = np.array(wall.begin) + along * at + np.array([-along[1], along[0]]) * off
    left, right = middle + along * side / 2, middle - along * side / 2
    low = 0.08 - side / 2
    return quad([(*left, low), (*right, low), (*right, low + side), (*left, low + side)], WHITE, texture)


def things() -> Mesh:
    """Return the objects around the corridors, and the column in one of them."""
    around = [_thing(kind, high, colour).in_frame(placed(x, y, 0, 3 * x)) for kind, x, y, high, colour in THINGS]
    x, y, half = COLUMN
    tones: tuple[Colour, ...] = ((240, 120, 60), (246, 240, 226), (60, 150, 170), (250, 206, 80))
    blocks = [
        box((-half, -half, i * 0.05), (half, half, i * 0.05 + 0.05), tone).in_frame(placed(x, y, 0, 0.0))
        for i, tone in enumerate(tones)
    ]
    return joined(*around, *blocks)


def _thing(kind: str, high: float, colour: Colour) -> Mesh:
    pale: Colour = (244, 240, 230)
    if kind == "tin":
        label = turned([(0.0345, high * 0.3), (0.0345, high * 0.7)], pale)
        return joined(turned([(0.034, 0), (0.034, high), (0.0, high)], colour), label)
    if kind == "cone":
        band = turned([(0.0285, high * 0.35), (0.0195, high * 0.58)], pale)
        return joined(turned([(0.045, 0), (0.045, 0.012), (0.040, 0.012), (0.004, high), (0, high)], colour), band)
    if kind == "bottle":
        neck = turned([(0.012, high * 0.75), (0.012, high), (0, high)], pale)
        return joined(turned([(0.032, 0), (0.036, high * 0.5), (0.012, high * 0.75)], colour), neck)
    step = high / 3
    tones: tuple[Colour, ...] = (colour, pale, (colour[2], colour[0], colour[1]))
    return joined(
        *(
            box((-0.038 + 0.004 * i, -0.038, i * step), (0.036 - 0.006 * i, 0.036 - 0.004 * i, (i + 1) * step), tone)
            for i, tone in enumerate(tones)
        )
    )


def dock(picture: int) -> Mesh:
    """Return the dock in its frame: board with markers, a wedge on each side that leads in, two copper contacts."""
    half, high = drawings.BOARD_M / 2, 0.06 + drawings.BOARD_M / 2
    low = 0.06 - drawings.BOARD_M / 2
    board = quad([(0, -half, low), (0, half, low), (0, half, high), (0, -half, high)], WHITE, picture, light=1.0)
    parts = [board, box((-0.02, -half, 0), (-0.001, half, high), (230, 228, 220))]
    parts.append(box((0, -0.055, 0), (STOP_M, 0.055, STOP_HIGH_M), (244, 244, 242)))
    for side in GUIDES:
        outline = np.array(side)
        parts.append(prism(outline, 0, GUIDE_HIGH_M, (226, 178, 60)))
    for x, y in SPRINGS:
        parts.append(box((x - 0.012, y - 0.004, 0), (x + 0.02, y + 0.004, 0.004), (214, 130, 70)))
    return joined(*parts)


def surroundings(atlas: Atlas, board_m: tuple[float, float, float, float]) -> Mesh:
    """Return the board (x, y, x, y; m) on its table, and the hall."""
    board, floor, roof = (atlas.add(p) for p in (drawings.melamine(), drawings.parquet(), drawings.ceiling()))
    x, y, a, b = board_m
    tiles = np.array([[0, 4], [4, 4], [4, 0], [0, 0]])
    parts = [quad([(x, y, 0), (a, y, 0), (a, b, 0), (x, b, 0)], WHITE, board, tiles, light=1.0)]
    parts.append(box((x, y, -0.06), (a, b, -0.0005), (96, 70, 48)))
    half = HALL_M / 2
    low, high = -TABLE_M, HIGH_M - TABLE_M
    corners = [MIDDLE + np.array(p) * half for p in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    pictures = (hall.windows(), hall.gallery(), hall.library(), hall.banners())
    for (p, q), picture in zip(pairwise([*corners, corners[0]]), pictures, strict=True):
        parts.append(quad([(*q, low), (*p, low), (*p, high), (*q, high)], WHITE, atlas.add(picture), light=0.95))
    tiles = np.array([[0, 3], [3, 3], [3, 0], [0, 0]])
    ground = [(*c, low) for c in corners]
    parts.append(quad(ground, WHITE, floor, tiles, light=0.9))
    parts.append(quad([(*c, high) for c in corners[::-1]], WHITE, roof, tiles, light=0.95))
    return joined(*parts)


def robot() -> Mesh:
    """Return the robot as the view from above shows it: a rat-sized hull, ears, eyes, wheels, the i on its back."""
    hull: Colour = (206, 52, 46)
    white: Colour = (250, 250, 250)
    profile = [(0.045, 0.012), (0.05, 0.03), (0.05, 0.05), (0.042, 0.066), (0.026, 0.074), (0.0, 0.076)]
    parts = [turned(profile, hull, 20).in_frame(np.diag([1.7, 1.0, 1.0, 1.0]))]
    for side in (-1, 1):
        ear = turned([(0.017, 0), (0.017, 0.008), (0, 0.008)], (240, 170, 170), 10)
        eye = turned([(0.006, 0), (0.006, 0.006), (0, 0.007)], (20, 20, 22), 8)
        wheel = side * 0.049
        parts += [ear.in_frame(placed(0.032, side * 0.036, 0.064)), eye.in_frame(placed(0.066, side * 0.014, 0.056))]
        parts.append(box((-0.02, wheel - 0.006, 0), (0.02, wheel + 0.006, 0.04), (30, 30, 34)))
    parts.append(lid(np.array([(-0.052, -0.006), (0.012, -0.006), (0.012, 0.006), (-0.052, 0.006)]), 0.0775, white))
    parts.append(turned([(0.009, 0.0765), (0, 0.078)], white, 12).in_frame(placed(0.03, 0, 0)))
    parts.append(box((-0.135, -0.003, 0.02), (-0.08, 0.003, 0.026), (240, 170, 170)))
    return joined(*parts)


def decoys(texture: int) -> tuple[Mesh, ...]:
    """Return false markers: the dock's board once more, hung on walls that are long enough."""
    long = [wall for row in walls() for wall in row if wall.length > 0.16]
    return tuple(_poster(wall, wall.length / 2, 0.14, texture, 2 * STAY_OFF_M) for wall in long)


def everything(atlas: Atlas, with_maze: bool = True) -> tuple[Mesh, tuple[Mesh, ...]]:
    """Return all that does not move, and false markers; without a maze the dock stands alone on the board."""
    board = atlas.add(drawings.dock_board())
    parts = [
        surroundings(atlas, BOARD if with_maze else OPEN_FLOOR),
        dock(board).in_frame(placed(DOCK[0], DOCK[1], 0, DOCK[2])),
    ]
    if not with_maze:
        return joined(*parts), ()
    return joined(*parts, maze(atlas), things()), decoys(board)
