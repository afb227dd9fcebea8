import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from robots.kit.drivers.mercury.beds import FIRST
from simulators.mercury.camera import HEIGHT, WIDTH, expose
from simulators.mercury.sand import COVER_MM, X0_MM, Y0_MM
from tests.unit.sand_beds import fresh


@settings(deadline=None, max_examples=6)
@given(st.integers(-230, 230), st.integers(300, 540), st.floats(0.05, 0.5))
def test_sand_is_moved_never_made_nor_lost(x, y, seconds):
    bed = fresh(2)
    before = float(bed.sand.sum(dtype=np.float64))
    assert bed.blow(x, y, seconds) >= 0
    assert abs(float(bed.sand.sum(dtype=np.float64)) - before) < before * 1e-5
    assert (bed.sand >= bed.rigid - 1e-3).all()


def test_a_hole_is_dug():
    bed = fresh(2)
    before = bed.sand.copy()
    for _ in range(10):
        bed.blow(60, 420, 0.15)
    hole = bed.sand[420 - Y0_MM, 60 - X0_MM]
    assert hole < before[420 - Y0_MM, 60 - X0_MM] - 8


def test_everything_is_buried_at_first_and_one_can_be_laid_bare():
    bed = fresh(2)
    assert not ((bed.sand - bed.rigid < COVER_MM * 0.3) & (bed.rigid > 0)).any()
    x, y = FIRST["watch"]
    for _ in range(8):
        for dx, dy in ((-8, 8), (8, 8), (8, -8), (-8, -8), (0, 0)):
            bed.blow(x + dx, y + dy, 0.15)
    r, c = y - Y0_MM, x - X0_MM
    bare = (bed.sand - bed.rigid < COVER_MM)[r - 8 : r + 8, c - 8 : c + 8]
    assert bare.mean() > 0.5


def test_the_bed_survives_a_restart(tmp_path):
    bed = fresh(2)
    bed.blow(0, 420, 0.3)
    bed.save(tmp_path / "bed.npy")
    other = fresh(2)
    assert other.restore(tmp_path / "bed.npy")
    assert np.array_equal(other.sand, bed.sand)
    assert np.allclose(other.light, bed.light, atol=0.02)


def test_a_spoilt_file_leaves_a_fresh_bed(tmp_path):
    (tmp_path / "bed.npy").write_bytes(b"\x93NUMPY rubbish")
    assert not fresh(2).restore(tmp_path / "bed.npy")


def test_the_camera_is_as_in_the_paper_and_sees_less_from_lower():
    bed, rng = fresh(2), np.random.default_rng(1)
    up = expose(bed, [(0, 0.42, 0.075, 0)], 1 / 150, rng)
    assert up.shape == (HEIGHT, WIDTH) == (165, 192)
    assert up.dtype == np.uint8
    down = expose(bed, [(0, 0.42, 0.0, 0)], 1 / 150, rng)
    for picture in (up, down):  # the compromise focus: both still show grain
        assert float(np.abs(np.diff(picture.astype(int), axis=1)).mean()) > 1.2


def test_motion_blurs_the_picture():
    bed, rng = fresh(2), np.random.default_rng(1)
    sharp = expose(bed, [(0, 0.42, 0, 0)], 1 / 64, rng)
    moving = expose(bed, [(0.0006 * i, 0.42, 0, 0) for i in range(8)], 1 / 64, rng)
    edges = [float(np.abs(np.diff(p.astype(int), axis=1)).mean()) for p in (sharp, moving)]
    assert edges[1] < edges[0] * 0.8
