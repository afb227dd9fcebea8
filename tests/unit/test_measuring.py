"""Objects are measured in pictures by the markers that are printed on them; judged by the simulator's positions."""

import copy

import cv2
import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from robots.kit.arms.described import posture
from robots.kit.description import load
from robots.kit.vision.alignment import Template
from robots.kit.vision.measuring import Measurer
from robots.kit.vision.prints import cameras_of, codes_of, prints_of
from simulators.puma.cell import bricks, things
from simulators.puma.plant import Plant
from simulators.puma.render import RasterRenderer

DESCRIPTION = load("puma")


def on_table(name, pose):
    return [0.0096]


FIRST = {name: [things()[name].first] for name in bricks()}
NEAR_M, NEAR_DEG = 0.0005, 0.5


@pytest.fixture(scope="module")
def measurer():
    return Measurer(cameras_of(DESCRIPTION), prints_of(DESCRIPTION), codes_of(DESCRIPTION))


@pytest.fixture(scope="module")
def renderer():
    return RasterRenderer(Plant(posture(DESCRIPTION, "ready")).model, 640, 480)


@pytest.fixture
def plant():
    return Plant(posture(DESCRIPTION, "ready"))


def pictures(renderer, plant, dice, *views):
    """Return grey pictures as the owner gets them: with a sensor's noise, as JPEG."""
    mujoco.mj_kinematics(plant.model, plant.data)
    found = {}
    for view in views or ("front", "side"):
        drawn = renderer.take(plant.data, view).astype(int)
        noisy = np.clip(drawn + dice.integers(-2, 3, drawn.shape), 0, 255).astype(np.uint8)
        coded = cv2.imencode(".jpg", noisy[:, :, ::-1], [cv2.IMWRITE_JPEG_QUALITY, 94])[1]
        found[view] = cv2.cvtColor(cv2.imdecode(coded, cv2.IMREAD_COLOR), cv2.COLOR_BGR2GRAY)
    return found


def scatter(plant, dice):
    """Put the bricks anywhere on the table, turned anyhow."""
    for number, name in enumerate(bricks()):
        place = np.array([dice.uniform(0.36, 0.64), -0.46 + 0.12 * number + dice.uniform(0, 0.06), 0.0096])
        half = dice.uniform(0, np.pi)
        plant.put(name, place, np.array([np.cos(half), 0.0, 0.0, np.sin(half)]))


def off(pose, true):
    """Return how far (m, degrees) a pose is from the true one."""
    turned = Rotation.from_matrix(pose[:3, :3].T @ true[:3, :3]).magnitude()
    return float(np.linalg.norm(pose[:3, 3] - true[:3, 3])), float(np.degrees(turned))


def check_near(pose, true, times=1):
    metres, degrees = off(pose, true)
    assert metres < times * NEAR_M, f"{1000 * metres:.2f} mm"
    assert degrees < 3 * NEAR_DEG, f"{degrees:.2f} degrees"


def test_bricks_anywhere_on_the_table_are_measured_within_half_a_millimetre(measurer, renderer, plant):
    """Nothing is known of where they lie. None is measured wrongly, most are measured; one is in the arm's shadow."""
    dice, all_off, count = np.random.default_rng(1), [], 0
    for _ in range(16):
        scatter(plant, dice)
        looked = measurer.measure(pictures(renderer, plant, dice), {}, on_table)
        assert looked.noticed >= looked.poses.keys()
        all_off += [off(pose, plant.pose(name)) for name, pose in looked.poses.items()]
        count += len(bricks())
    metres, degrees = np.array(all_off).T
    assert len(all_off) >= 0.85 * count
    assert metres.max() < NEAR_M
    assert np.mean(degrees < NEAR_DEG) >= 0.95
    assert degrees.max() < 3 * NEAR_DEG
    assert np.median(metres) < 0.0002


def test_one_camera_alone_is_enough_where_the_height_is_known_and_not_without(measurer, renderer, plant):
    dice = np.random.default_rng(2)
    front = pictures(renderer, plant, dice, "front")
    looked = measurer.measure(front, FIRST, on_table)
    assert len(looked.poses) >= 4
    for name, pose in looked.poses.items():
        check_near(pose, plant.pose(name), 2)
    unknown = measurer.measure(front, {}, lambda name, pose: [])
    assert unknown.poses == {}
    assert unknown.noticed >= looked.poses.keys()


def marker(code, corners, dice, fine=8):
    """Return a picture (64 x 64) of a marker with those corners (px), with its white margin, on a dark brick."""
    cells = np.pad(np.pad(255 * code, 1), 1, constant_values=245).astype(np.uint8)
    large, size = np.kron(cells, np.ones((8, 8), np.uint8)), 8 * (len(cells) - 2)
    printed = np.array([[8, 8], [8 + size, 8], [8 + size, 8 + size], [8, 8 + size]])
    # the middle of a pixel is its place
    there = cv2.getPerspectiveTransform(np.float32(printed - 0.5), np.float32((corners + 0.5) * fine - 0.5))
    flat = np.full((64 * fine, 64 * fine), 60, np.uint8)
    cv2.warpPerspective(large, there, flat.shape, flat, borderMode=cv2.BORDER_TRANSPARENT)
    seen = cv2.resize(flat, (64, 64), interpolation=cv2.INTER_AREA).astype(int)
    return np.clip(seen + dice.integers(-2, 3, seen.shape), 0, 255).astype(np.uint8)


def test_a_small_marker_is_aligned_to_a_quarter_of_a_pixel():
    """Of eight to fourteen pixels, seen aslant: from a place that is nearly a pixel off it is found."""
    dice, code = np.random.default_rng(5), codes_of(DESCRIPTION)[23]
    template, offs = Template(code), []
    for _ in range(200):
        turn, lean = Rotation.from_euler("z", dice.uniform(0, 360), degrees=True), dice.uniform(0.6, 1.0)
        half = dice.uniform(4.0, 7.0) * np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
        corners = dice.uniform(28, 36, 2) + turn.apply(half)[:, :2] * (1.0, lean)
        found = template.align(marker(code, corners, dice), corners + dice.uniform(-0.7, 0.7, 2))
        offs.append(np.inf if found is None else np.abs(found - corners).max())
    assert np.mean(np.array(offs) < 0.25) > 0.95, np.sort(offs)[-20:]


def test_a_stack_is_measured_brick_by_brick(measurer, renderer, plant):
    a = plant.place("a")
    for level, name in enumerate("bc", 1):
        plant.put(name, a + np.array([0.0, 0.0, level * 0.0192]), np.array([1.0, 0.0, 0.0, 0.0]))
    taken = pictures(renderer, plant, np.random.default_rng(3))
    looked = measurer.measure(taken, {}, lambda name, pose: [0.0096 + 0.0192 * level for level in range(4)])
    for name in "bc":
        check_near(looked.poses[name], plant.pose(name))


@pytest.mark.parametrize("bad", ["noise", "black", "white", "nobody"])
def test_a_bad_picture_shows_nothing(measurer, renderer, plant, bad):
    dice = np.random.default_rng(4)
    shape = (480, 640)
    made = {
        "noise": lambda: dice.integers(0, 256, shape).astype(np.uint8), "black": lambda: np.zeros(shape, np.uint8),
        "white": lambda: np.full(shape, 255, np.uint8),
    }  # fmt: skip
    if bad == "nobody":
        for count, name in enumerate((*bricks(), "rod")):
            plant.put(name, np.array([-2.2, 0.4 * count, -0.74]), np.array([1.0, 0.0, 0.0, 0.0]))
        looked = measurer.measure(pictures(renderer, plant, dice), FIRST, on_table)
    else:
        looked = measurer.measure({view: made[bad]() for view in ("front", "side")}, FIRST, on_table)
    assert (looked.poses, looked.noticed, looked.cameras) == ({}, frozenset(), ())


def test_one_bad_picture_does_not_spoil_the_other(measurer, renderer, plant):
    dice = np.random.default_rng(5)
    both = pictures(renderer, plant, dice)
    both["side"] = dice.integers(0, 256, both["side"].shape).astype(np.uint8)
    looked = measurer.measure(both, FIRST, on_table)
    assert [camera.name for camera in looked.cameras] == ["front"]
    for name, pose in looked.poses.items():
        check_near(pose, plant.pose(name), 2)


def test_a_picture_of_another_size_is_refused(measurer):
    with pytest.raises(ValueError, match="described with pictures of"):
        measurer.measure({"front": np.zeros((240, 320), np.uint8)}, {}, on_table)


def test_a_number_on_two_faces_is_refused():
    described = copy.deepcopy(DESCRIPTION)
    described["object"][1]["markers"][0]["number"] = described["object"][0]["markers"][0]["number"]
    with pytest.raises(ValueError, match="two faces"):
        prints_of(described)


def test_any_picture_is_measured_or_not_without_an_error(measurer, renderer, plant):
    """Pictures that are warped, mirrored, cut and mixed: cameras that somebody has pushed, hands, other markers."""
    dice = np.random.default_rng(6)
    taken = pictures(renderer, plant, dice)
    for _ in range(15):
        odd = {}
        for view, picture in taken.items():
            corners = np.array([[0, 0], [640, 0], [640, 480], [0, 480]], np.float32)
            moved = (corners + dice.normal(0, 90, (4, 2))).astype(np.float32)
            made = cv2.warpPerspective(picture, cv2.getPerspectiveTransform(corners, moved), (640, 480))
            made = made[:, ::-1] if dice.random() < 0.2 else made
            x, y = dice.integers(0, 500), dice.integers(0, 300)
            made = made.copy()
            made[y : y + 150, x : x + 120] = dice.integers(0, 256)
            odd[view] = made
        if dice.random() < 0.3:
            odd["front"] = odd["side"]
        looked = measurer.measure(odd, FIRST, on_table)
        assert all(np.isfinite(pose).all() for pose in looked.poses.values())
