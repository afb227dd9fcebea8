"""The scene that the cameras see: table and wall, the plate, the arm, bricks with their markers, rod, mug, threads."""

import cv2
import mujoco
import numpy as np
from PIL import Image, ImageDraw, ImageFont

from robots.kit.description import load
from simulators.common.arm.scene import JUDGE
from simulators.common.mesh import WHITE, Colour, Mesh, joined, quad
from simulators.common.texture import Atlas, Picture
from simulators.puma import cell, rod
from simulators.puma.cell import DRIVER, PLATE, STUD_RADIUS, Bearer, Floats, bearers, bricks, plate_place, things
from simulators.puma.scene import MUG, MUG_M, TABLE_M
from simulators.puma.shapes import Shape, box, cylinder, flat, together, tube

TILE_M = 0.2  # of the table's pattern
PLATE_TINT: Colour = (132.0, 142.0, 150.0)
THREAD_M, THREAD_TINT = 0.0011, (70.0, 66.0, 74.0)
COLLAR_M = 0.0135  # half the edge of a collar of the rod, which is only seen
BOW_M = 0.4  # the lowest part of a slack thread, which bends
ABOVE_M = 0.0002  # a print over its surface


def table_pattern() -> Picture:
    """Return 0.2 m x 0.2 m of the table: a light laminate with fine lines each 0.1 m."""
    size, grain = 256, np.random.default_rng(3).normal(0, 1.6, (256, 256, 1))
    picture = np.full((size, size, 3), (228.0, 224.0, 214.0)) + cv2.GaussianBlur(grain, (0, 0), 1.2)[:, :, None]
    for k in (0, size // 2):
        picture[k : k + 2] -= 15
        picture[:, k : k + 2] -= 15
    return np.asarray(np.clip(picture, 0, 255), np.uint8)


def marker(number: int) -> Picture:
    """Return the print of a marker with its white margin."""
    fine, known = 128, cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, load(DRIVER)["markers"]["dictionary"]))
    cells = 255 * np.pad(cv2.aruco.Dictionary.getBitsFromByteList(known.bytesList[number][None], known.markerSize), 1)
    large = np.kron(cells, np.ones((fine, fine), np.uint8))
    large = np.pad(large, fine // 2, constant_values=245)
    small = cv2.resize(large, (128, 128), interpolation=cv2.INTER_AREA)
    return np.asarray(np.repeat(np.clip(small, 14, 245)[:, :, None], 3, axis=2), np.uint8)


def letter(text: str, paper: Colour) -> Picture:
    """Return a letter on a colour, light on dark or dark on light."""
    image = Image.new("RGB", (128, 128), tuple(int(v) for v in paper))
    ink = (24, 24, 28) if np.dot(paper, (0.3, 0.6, 0.1)) > 110 else (244, 244, 240)
    ImageDraw.Draw(image).text((64, 64), text, fill=ink, font=ImageFont.load_default(104), anchor="mm")
    return np.asarray(image)


def surroundings(atlas: Atlas) -> tuple[Mesh, int]:
    """Return what never moves but the plate, and the number of the table's texture."""
    pattern, t, low = atlas.add(table_pattern()), TABLE_M, -0.04
    uv = np.array([(-t, t), (t, t), (t, -t), (-t, -t)]) / TILE_M
    top = quad([(-t, -t, 0), (t, -t, 0), (t, t, 0), (-t, t, 0)], WHITE, pattern, uv, light=1.0)
    rims = [
        quad([(t, -t, low), (t, t, low), (t, t, 0), (t, -t, 0)], (150, 132, 108), light=0.9),
        quad([(-t, -t, low), (t, -t, low), (t, -t, 0), (-t, -t, 0)], (150, 132, 108), light=0.8),
        quad([(t, t, low), (-t, t, low), (-t, t, 0), (t, t, 0)], (150, 132, 108), light=0.7),
    ]
    wall = quad([(-1.6, -4, -0.75), (-1.6, 4, -0.75), (-1.6, 4, 3), (-1.6, -4, 3)], (176, 190, 198), light=1.05,
                darker=0.75)  # fmt: skip
    side = quad([(4, 2.2, -0.75), (-4, 2.2, -0.75), (-4, 2.2, 3), (4, 2.2, 3)], (168, 182, 190), light=1.0, darker=0.75)
    floor = quad([(-4, -4, -0.75), (4, -4, -0.75), (4, 4, -0.75), (-4, 4, -0.75)], (120, 124, 128), light=0.9)
    return joined(top, *rims, wall, side, floor), pattern


def _studs(bearer: Bearer, tint: Colour) -> Shape:
    high = float(load(DRIVER)["clutch"]["stud_m"]) / 2
    one = cylinder(STUD_RADIUS, high, tint, 10, bottom=False)
    return together(*(one.moved(_at(x, y, bearer.half[2] + high)) for x, y in bearer.studs))


def _at(x: float, y: float, z: float) -> Floats:
    pose = np.eye(4)
    pose[:3, 3] = x, y, z
    return pose


def plate() -> Shape:
    """Return the plate where it is."""
    (one,) = (bearer for bearer in bearers() if bearer.name == PLATE)
    x, y, z = plate_place()
    return together(box(one.half, PLATE_TINT), _studs(one, PLATE_TINT)).moved(_at(x, y, z))


def _prints(name: str, atlas: Atlas) -> list[Shape]:
    """Return the markers that are printed on an object."""
    found = []
    for one in cell.prints(name):
        middle, half = one.middle + ABOVE_M * np.cross(one.right, one.upward), one.printed / 2
        found.append(flat(middle, half * one.right, half * one.upward, WHITE, atlas.add(marker(one.number))))
    return found


def _brick(bearer: Bearer, atlas: Atlas) -> Shape:
    """Return a brick with its markers, and its letter beside those on its long sides."""
    r, g, b = (255.0 * part for part in things()[bearer.name].colour)
    tint = (r, g, b)
    parts = [box(bearer.half, tint), _studs(bearer, tint), *_prints(bearer.name, atlas)]
    sign = atlas.add(letter(bearer.name.upper(), tint))
    for out in (-1.0, 1.0):
        right, up = np.array([-out, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])
        middle = np.array([0.0, out * (bearer.half[1] + ABOVE_M), 0.0])
        parts += [flat(middle + side * 0.021 * right, 0.008 * right, 0.008 * up, WHITE, sign) for side in (-1, 1)]
    return together(*parts)


def _rod(atlas: Atlas) -> Shape:
    """Return the rod with a light band where it is grasped, and with the collars that carry its markers."""
    thing = things()[rod.ROD]
    r, g, b = (255.0 * part for part in thing.colour)
    radius, half = thing.size[0] / 2, thing.size[2] / 2
    ends = [cylinder(radius + 0.0003, 0.006, (240, 240, 236)).moved(_at(0, 0, s * (half - 0.006))) for s in (-1, 1)]
    band = cylinder(radius + 0.0003, 0.02, (240, 240, 236))
    collars = [box((COLLAR_M, COLLAR_M, COLLAR_M), (240, 240, 236)).moved(_at(0, 0, s * 0.09)) for s in (-1, 1)]
    return together(cylinder(radius, half, (r, g, b)), band, *ends, *collars, *_prints(rod.ROD, atlas))


def _mug() -> Shape:
    """Return a mug with a handle."""
    radius, half = MUG_M
    tint, dark = (196.0, 60.0, 58.0), (96.0, 30.0, 30.0)
    inside = cylinder(radius - 0.004, 0.0005, dark).moved(_at(0, 0, half + 0.0006))
    handle = [box((0.004, 0.006, 0.022), tint).moved(_at(radius + 0.020, 0, 0))]
    handle += [box((0.012, 0.006, 0.004), tint).moved(_at(radius + 0.010, 0, s * 0.020)) for s in (-1, 1)]
    return together(cylinder(radius, half, tint), inside, *handle)


def _arm(model: mujoco.MjModel) -> dict[str, Shape]:
    """Return the arm's links as their description has them to be seen."""
    found: dict[str, list[Shape]] = {}
    for g in range(model.ngeom):
        if model.geom_contype[g] or model.geom_conaffinity[g] or model.geom_group[g] == JUDGE:
            continue
        r, green, b = (255.0 * float(part) for part in model.geom_rgba[g, :3])
        size, pose = model.geom_size[g], np.eye(4)
        turn = np.zeros(9)
        mujoco.mju_quat2Mat(turn, model.geom_quat[g])
        pose[:3, :3], pose[:3, 3] = turn.reshape(3, 3), model.geom_pos[g]
        if model.geom_type[g] == mujoco.mjtGeom.mjGEOM_BOX:
            shape = box(size, (r, green, b))
        else:
            shape = cylinder(float(size[0]), float(size[1]), (r, green, b), 28)
        found.setdefault(model.body(model.geom_bodyid[g]).name, []).append(shape.moved(pose))
    return {name: together(*shapes) for name, shapes in found.items()}


def moving(model: mujoco.MjModel, atlas: Atlas) -> dict[str, Shape]:
    """Return the shapes of all bodies but the plate, in the bodies' frames, by name."""
    found = _arm(model)
    by_name = {bearer.name: bearer for bearer in bearers()}
    for name in bricks():
        found[name] = _brick(by_name[name], atlas)
    return {**found, rod.ROD: _rod(atlas), MUG: _mug()}


def thread(above: Floats, below: Floats, length: float) -> Mesh:
    """Return a thread between two points (m); the longer it is than their distance, the more its lowest part bends."""
    slack = max(0.0, length - float(np.linalg.norm(above - below)))
    share = np.linspace(0.0, 1.0, 13)
    knee = below + (above - below) * min(1.0, BOW_M / float(np.linalg.norm(above - below)))
    low = below + share[:, None] * (knee - below)
    low[:, 0] += 2 / np.pi * np.sqrt(BOW_M * slack) * np.sin(np.pi * share) ** 2
    return tube(np.concatenate([low, above[None]]), THREAD_M, THREAD_TINT)


def shadow(shape: Mesh, sun: Floats, height: float, texture: int, low: Floats, high: Floats) -> Mesh:
    """Return the shadow of a mesh in the world's frame on a level surface at a height, inside two corners (x, y)."""
    corners = shape.corners - (shape.corners[:, :, 2:] - height) * (sun / sun[2])
    corners = corners[(shape.corners[:, :, 2] > height - 0.001).all(axis=1)]
    corners[:, :, :2] = np.clip(corners[:, :, :2], low, high)
    corners[:, :, 2] = height + ABOVE_M
    count = len(corners)
    tint = np.full((count, 3), 255.0) if texture >= 0 else np.tile(PLATE_TINT, (count, 1))
    uv = corners[:, :, :2] * (1.0, -1.0) / TILE_M
    return Mesh(corners, uv, np.full((count, 3), 0.68), tint, np.full(count, texture))
