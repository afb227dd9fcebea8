"""Pictures of the PUMA 560's cell: the markers can be read, the cameras are where they are said to be, faults show."""

import io
import json
import urllib.request

import cv2
import mujoco
import numpy as np
import pytest
from PIL import Image

from robots.kit.arms.described import posture
from robots.kit.description import load, views
from robots.kit.vision.markers import Markers
from robots.kit.vision.prints import cameras_of, codes_of, prints_of
from simulators.common.arm.cameras import SharedScene
from simulators.common.raster import Lens, looking
from simulators.puma import rod
from simulators.puma.cameras import Cameras
from simulators.puma.cell import bearers, bricks
from simulators.puma.cell import prints as drawn
from simulators.puma.plant import Plant
from simulators.puma.render import RasterRenderer
from simulators.puma.scene import MUG, MUG_M

DESCRIPTION = load("puma")
CAMERA = DESCRIPTION["camera"]
SIZE = CAMERA["width"], CAMERA["height"]
HOME = posture(DESCRIPTION, "home")
PRINTS = {name: prints for name, prints in prints_of(DESCRIPTION).items() if name in bricks()}
OWNER = {one.number: (name, one) for name, prints in PRINTS.items() for one in prints}
CODES = codes_of(DESCRIPTION)
BITS = {number: CODES[number].tolist() for number in OWNER}
SIDES = {number: one.side for number, (_, one) in OWNER.items()}


@pytest.fixture(scope="module")
def renderer():
    return RasterRenderer(Plant(HOME).model, *SIZE)


@pytest.fixture
def plant():
    return Plant(HOME)


def view(name):
    """Return a camera's transform (4 x 4) from the world, and its lens."""
    (one,) = (table for table in DESCRIPTION["view"] if table["name"] == name)
    return looking(np.array(one["place"]), np.array(one["at"])), Lens(*SIZE, float(np.radians(one["field_deg"])))


def pixel(point, name):
    """Return where a camera sees a point (m)."""
    towards, lens = view(name)
    x, y, z = towards[:3, :3] @ point + towards[:3, 3]
    return np.array([SIZE[0] / 2 + lens.focal * x / z - 0.5, SIZE[1] / 2 + lens.focal * y / z - 0.5])


def on_level(at, name, height):
    """Return which point at a height (m) a camera sees at a pixel."""
    towards, lens = view(name)
    ray = np.array([(at[0] + 0.5 - SIZE[0] / 2) / lens.focal, (at[1] + 0.5 - SIZE[1] / 2) / lens.focal, 1.0])
    way, seat = towards[:3, :3].T @ ray, -towards[:3, :3].T @ towards[:3, 3]
    return seat + way * (height - seat[2]) / way[2]


def crossing(corners):
    """Return where the diagonals of a marker cross: its middle."""
    a, b, c, d = corners
    share = np.linalg.solve(np.stack([c - a, b - d], axis=-1), b - a)[0]
    return a + share * (c - a)


def find(picture, name):
    _, lens = view(name)
    return Markers(BITS, SIDES, lens.field).find(cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY))


def test_the_cameras_of_the_description_are_those_of_its_views():
    assert tuple(table["name"] for table in DESCRIPTION["view"]) == views(DESCRIPTION)


def test_the_prints_of_the_bricks_fit_their_faces_and_are_drawn_as_they_are_described():
    assert tuple(PRINTS) == bricks()
    edges = 2 * np.array(bearers()[0].half)
    for name, prints in PRINTS.items():
        assert len(prints) == 5, "on all faces but the underside"
        for one, print_ in zip(prints, drawn(name), strict=True):
            assert print_.number == one.number
            assert print_.printed == pytest.approx(one.side * 7 / 6)
            for direction in (one.right, one.upward):
                assert print_.printed <= np.abs(direction @ edges)
            assert one.middle == pytest.approx(one.out * edges / 2)


def test_a_calibrated_camera_sees_a_point_where_the_simulators_does():
    for camera in cameras_of(DESCRIPTION):
        points = np.array([[0.6, -0.2, 0.01], [0.42, 0.3, 0.3], [0.3, 0.0, 0.0]])
        assert camera.project(points) == pytest.approx(np.array([pixel(point, camera.name) for point in points]))


def test_the_front_camera_reads_the_marker_on_each_brick_within_a_millimetre(renderer, plant):
    found = {marker.number: marker for marker in find(renderer.take(plant.data, "front"), "front")}
    tops = {prints[0].number: name for name, prints in PRINTS.items()}
    assert tops.keys() <= found.keys()
    for number, name in tops.items():
        place = plant.place(name)
        seen = on_level(crossing(found[number].corners), "front", place[2] + 0.0096)
        off = np.linalg.norm(seen[:2] - place[:2])
        assert off < 0.001
        assert found[number].sighting.z == pytest.approx(view("front")[0][2] @ [*place, 1.0], rel=0.07)


def test_the_side_camera_reads_a_marker_of_most_bricks_where_it_is(renderer, plant):
    found = find(renderer.take(plant.data, "side"), "side")
    assert len({OWNER[marker.number][0] for marker in found}) >= 3
    for marker in found:
        brick, face = OWNER[marker.number]
        pose = plant.pose(brick)
        where = pose[:3, :3] @ face.middle + pose[:3, 3]
        assert np.abs(crossing(marker.corners) - pixel(where, "side")).max() < 0.7


def around(renderer, plant, place, name):
    """Return the pixels, shape (49, 3), about a point (m)."""
    x, y = pixel(np.array(place), name).round().astype(int)
    return renderer.take(plant.data, name)[y - 3 : y + 4, x - 3 : x + 4].reshape(-1, 3).astype(int)


@pytest.mark.parametrize("name", ["front", "side"])
def test_rod_and_threads_are_seen_where_they_are(renderer, plant, name):
    for along in (-0.05, 0.06):
        seen = around(renderer, plant, plant.place(rod.ROD) + np.array([along, 0.0, 0.0]), name)
        assert (np.abs(seen - (204, 120, 166)).max(axis=1) < 40).mean() > 0.4
    lit = renderer.take(plant.data, name).astype(int).sum(axis=2)
    for x in rod.THREADS_X:
        column, row = pixel(np.array([x, 0.30, 0.345]), name).round().astype(int)
        line = lit[row, column - 6 : column + 7]
        assert line.min() < 0.75 * np.median(line), "a dark line"


def moved(plant, *changes):
    for name, place in changes:
        plant.put(name, np.array(place), np.array([1.0, 0.0, 0.0, 0.0]))
    mujoco.mj_kinematics(plant.model, plant.data)


def test_a_mug_and_a_missing_brick_show(renderer, plant):
    moved(plant, (MUG, (0.52, 0.10, MUG_M[1])), ("c", (-2.2, 0.9, -0.74)))
    for name in views(DESCRIPTION):
        red, green, _ = around(renderer, plant, (0.52, 0.10, 0.05), name).T
        assert (red > 2 * green).mean() > 0.9
    names = {OWNER[m.number][0] for m in find(renderer.take(plant.data, "front"), "front")}
    assert names >= {"a", "b", "d"}
    assert "c" not in names


def test_a_lifted_rod_bends_its_threads(renderer, plant):
    before = renderer.take(plant.data, "side").astype(int)
    at = int(plant.model.joint(f"{rod.ROD}_free").qposadr[0])
    plant.data.qpos[at + 2] += 0.03
    mujoco.mj_kinematics(plant.model, plant.data)
    after = renderer.take(plant.data, "side").astype(int)
    x, y = pixel(np.array([0.42, 0.30, 0.50]), "side").round().astype(int)
    changed = np.abs(after - before).max(axis=2)[y - 2 : y + 3, x - 40 : x + 41] > 40
    assert changed.any(), "the thread is elsewhere"


def test_each_turn_of_a_brick_is_drawn_with_the_light_of_its_sides(renderer, plant):
    flat = renderer.take(plant.data, "front")
    at = int(plant.model.joint("a_free").qposadr[0])
    plant.data.qpos[at + 3 : at + 7] = [np.cos(0.4), 0.0, 0.0, np.sin(0.4)]
    mujoco.mj_kinematics(plant.model, plant.data)
    turned = {m.number: m for m in find(renderer.take(plant.data, "front"), "front")}
    straight = {m.number: m for m in find(flat, "front")}
    edges = [one[0].corners[1] - one[0].corners[0] for one in (turned, straight)]
    angle = np.degrees(np.arctan2(*edges[0][::-1]) - np.arctan2(*edges[1][::-1]))
    assert 30 < (-angle) % 360 < 62, "0.8 rad, seen at an angle"


def test_the_cameras_serve_pictures_of_the_shared_scene_with_noise(tmp_path, plant):
    shared = SharedScene(tmp_path / "scene.mem", plant.model.nq, begin=True)
    shared.write(plant.qpos)
    cameras = Cameras(tmp_path, seed=1, width=320)
    addresses = cameras.open(tmp_path)
    assert json.loads((tmp_path / "cameras.json").read_text()) == addresses
    assert tuple(addresses) == views(DESCRIPTION)
    assert (tmp_path / "seed").read_text().strip().isdigit(), "the arm's plant has the same errors"
    for address in addresses.values():
        with urllib.request.urlopen(f"{address}/snapshot.jpg", timeout=30) as answer:
            picture = np.asarray(Image.open(io.BytesIO(answer.read())))
        assert picture.shape == (240, 320, 3)
        assert 120 < picture.mean() < 230
    first, second = (cameras.take("front").astype(int) for _ in range(2))
    assert 0 < np.abs(first - second).max() <= 4
