"""The rasteriser by properties: depth as MuJoCo's rays measure it, nearest first, textures averaged, nothing behind."""

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from simulators.common.mesh import WHITE, box, joined, lid, placed, prism, quad, turned
from simulators.common.raster import NEAR_M, Canvas, Lens, looking
from simulators.common.texture import Atlas

LENS = Lens(64, 48, np.radians(100))
EYE = np.eye(4)  # looks along z from the origin
FEW = settings(max_examples=25, deadline=None)


def facing(z, half=100.0, tint=WHITE, texture=-1, uv=None, light=1.0):
    """Return a square that faces the camera `EYE`."""
    corners = [(-half, half, z), (half, half, z), (half, -half, z), (-half, -half, z)]
    return quad(corners, tint, texture, uv, light=light)


def drawn(*meshes, view=EYE, atlas=None, lens=LENS, noise=0):
    canvas = Canvas(lens, atlas or Atlas(), noise)
    canvas.begin()
    for mesh in meshes:
        canvas.draw(mesh, view)
    return canvas


coordinate = st.floats(-1.0, 1.0)
boxes = st.lists(st.tuples(coordinate, coordinate, st.floats(0.05, 0.4), st.floats(0.05, 0.6)), min_size=1, max_size=6)


@FEW
@given(boxes, st.floats(-np.pi, np.pi), st.floats(0.7, 1.5))
def test_depth_is_what_rays_measure(found, angle, high):
    """The same boxes in MuJoCo: the distance of each pixel, but for those at an edge."""
    spec = mujoco.MjSpec()
    meshes = []
    for x, y, half, tall in found:
        spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=[half, half, tall / 2], pos=[x, y, tall / 2])
        meshes.append(box((x - half, y - half, 0), (x + half, y + half, tall), WHITE))
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    place = np.array([2.2 * np.cos(angle), 2.2 * np.sin(angle), high])
    view = looking(place, np.zeros(3))
    depth = drawn(*meshes, view=view).depth()
    hit, wrong, tried = np.zeros(1, np.int32), 0, 0
    for row in range(0, LENS.height, 3):
        for column in range(0, LENS.width, 3):
            ray = np.array(
                [(column + 0.5 - LENS.width / 2) / LENS.focal, (row + 0.5 - LENS.height / 2) / LENS.focal, 1.0]
            )
            length = np.linalg.norm(ray)
            away = mujoco.mj_ray(model, data, place, view[:3, :3].T @ ray / length, None, 1, -1, hit)
            expected = away / length if away >= 0 else np.inf
            tried += 1
            wrong += not (depth[row, column] == expected or abs(depth[row, column] - expected) < 1e-3)
    assert wrong <= 0.02 * tried


@FEW
@given(st.permutations(range(4)))
def test_the_nearest_wins_in_whatever_order(order):
    tints = ((250, 0, 0), (0, 250, 0), (0, 0, 250), (250, 250, 0))
    meshes = [facing(1.0 + k, half=0.3 * (1 + k), tint=tints[k]) for k in range(4)]
    assert np.array_equal(drawn(*(meshes[k] for k in order)).picture(), drawn(*meshes).picture())
    assert tuple(drawn(*meshes).picture()[24, 32]) == tints[0]


@FEW
@given(st.floats(0.01, 50.0), st.floats(-0.7, 0.7))
def test_a_tilted_plane_has_the_depth_of_a_plane(away, tilt):
    corners = [
        (-100, 100, away + 100 * tilt),
        (100, 100, away + 100 * tilt),
        (100, -100, away - 100 * tilt),
        (-100, -100, away - 100 * tilt),
    ]
    depth = drawn(quad(corners, light=1.0)).depth()
    y = (np.arange(LENS.height) + 0.5 - LENS.height / 2) / LENS.focal
    expected = away / (1 - tilt * y)
    seen = (expected > 2 * NEAR_M) & (expected * (1 - tilt * y) > 0) & (np.abs(expected * y) < 99)
    assert np.allclose(depth[seen, 32], expected[seen], rtol=1e-3)


def test_what_is_behind_or_turned_away_is_not_drawn():
    away = facing(1.0)
    assert np.isinf(drawn(facing(-1.0)).depth()).all()
    flipped = quad([(100, 100, 1), (-100, 100, 1), (-100, -100, 1), (100, -100, 1)], light=1.0)
    assert np.isinf(drawn(flipped).depth()).all()
    assert np.isfinite(drawn(away).depth()).all()


def test_a_floor_that_goes_through_the_camera_is_cut_at_the_near_plane():
    floor = quad([(-50, 0.1, -50), (-50, 0.1, 50), (50, 0.1, 50), (50, 0.1, -50)], light=1.0)
    floor = (
        floor
        if np.isfinite(drawn(floor).depth()).any()
        else quad([(-50, 0.1, 50), (-50, 0.1, -50), (50, 0.1, -50), (50, 0.1, 50)], light=1.0)
    )
    depth = drawn(floor).depth()
    assert np.isfinite(depth[30:]).all(), "below the horizon"
    assert np.isinf(depth[:24]).all(), "above it"
    assert depth[47, 32] == pytest.approx(0.1 * LENS.focal / 23.5, rel=1e-3)


@pytest.mark.parametrize("away", [30.0, 100.0, 400.0])
def test_a_distant_pattern_is_averaged(away):
    """A chess board of which many fields share a pixel is grey, not black and white."""
    chess = np.kron(np.indices((64, 64)).sum(axis=0) % 2, np.ones((2, 2))) * 255
    atlas = Atlas()
    texture = atlas.add(np.repeat(chess[:, :, None], 3, axis=2).astype(np.uint8))
    picture = drawn(
        facing(away, half=away, texture=texture, uv=np.array([[0, 4], [4, 4], [4, 0], [0, 0]])), atlas=atlas
    ).picture()
    inner = picture[10:38, 16:48, 0].astype(float)
    assert inner.mean() == pytest.approx(127.5, abs=4)
    assert inner.std() < 40


def test_a_near_texture_is_where_it_belongs():
    quarters = np.zeros((64, 64, 3), np.uint8)
    quarters[:32, :32], quarters[:32, 32:], quarters[32:, :32], quarters[32:, 32:] = (
        (250, 0, 0),
        (0, 250, 0),
        (0, 0, 250),
        (250, 250, 0),
    )
    atlas = Atlas()
    picture = drawn(facing(1.0, half=0.5, texture=atlas.add(quarters)), atlas=atlas).picture()
    assert tuple(picture[18, 26]) == (250, 0, 0)
    assert tuple(picture[18, 38]) == (0, 250, 0)
    assert tuple(picture[30, 26]) == (0, 0, 250)
    assert tuple(picture[30, 38]) == (250, 250, 0)


@FEW
@given(st.floats(0.2, 3.0), st.floats(0.1, 1.0))
def test_light_and_tint_multiply(light, share):
    picture = drawn(facing(2.0, tint=(200 * share, 100, 50), light=light)).picture()
    assert picture[24, 32].astype(int).tolist() == pytest.approx(
        np.clip([200 * share * light, 100 * light, 50 * light], 0, 255), abs=1
    )


def test_two_pictures_of_the_same_differ_by_their_noise_only():
    canvas = drawn(facing(2.0, tint=(120, 120, 120)), noise=2)
    first, second = canvas.picture().astype(int), canvas.picture().astype(int)
    assert not np.array_equal(first, second)
    assert np.abs(first - 120).max() <= 3
    assert first.mean() == pytest.approx(120, abs=0.5)


def test_the_background_stands_where_nothing_is():
    picture = drawn(facing(2.0, half=0.2)).picture((7, 8, 9))
    assert tuple(picture[0, 0]) == (7, 8, 9)


def test_more_triangles_than_there_is_room_for():
    many = joined(*(facing(1.0 + k / 1000, half=0.3) for k in range(1500)))
    assert drawn(many).depth()[24, 32] == pytest.approx(1.0, abs=1e-3)


def test_solids_are_seen_from_outside_on_all_sides():
    solids = (
        box((-0.1, -0.1, 0), (0.1, 0.1, 0.2), WHITE), turned([(0.1, 0), (0.1, 0.2), (0, 0.2)], WHITE),
        prism(np.array([(-0.1, -0.1), (0.1, -0.1), (0.0, 0.1)]), 0, 0.2, WHITE),
    )  # fmt: skip
    for solid in solids:
        for angle in np.arange(0, 6.28, 0.7):
            view = looking(np.array([np.cos(angle), np.sin(angle), 0.5]), np.array([0, 0, 0.1]))
            near = drawn(solid.in_frame(placed(0, 0, 0, 0.3)), view=view).depth().min()
            assert 0.8 < near < 1.12, "its near side hides its far side"
    assert np.isfinite(
        drawn(
            lid(np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]), 0.0, WHITE),
            view=looking(np.array([0, -0.01, 1]), np.zeros(3)),
        ).depth()
    ).any()


@pytest.mark.parametrize("shape", [(3, 4), (5, 8), (64, 63), (0, 4)])
def test_a_texture_has_sides_that_are_powers_of_two(shape):
    with pytest.raises(ValueError, match="powers of two"):
        Atlas().add(np.zeros((*shape, 3), np.uint8))


def test_what_is_kept_is_in_all_further_pictures_and_hides_what_is_behind_it():
    canvas, plain = Canvas(LENS, Atlas()), Canvas(LENS, Atlas())
    wall, near, behind = facing(3.0, tint=(90, 0, 0)), facing(1.0, 0.2, (0, 90, 0)), facing(9.0, 5.0, (0, 0, 90))
    canvas.begin()
    canvas.draw(facing(3.0, 0.9, (90, 0, 0)), EYE)
    canvas.keep((7, 8, 9))
    for drawn_now in ((near,), (behind, near), ()):
        for one, meshes in ((canvas, drawn_now), (plain, (facing(3.0, 0.9, (90, 0, 0)), *drawn_now))):
            one.begin()
            for mesh in meshes:
                one.draw(mesh, EYE)
        assert np.array_equal(canvas.picture(), plain.picture((7, 8, 9)))
        assert np.array_equal(canvas.depth(), plain.depth())
    assert not np.array_equal(drawn(wall).picture(), canvas.picture())
