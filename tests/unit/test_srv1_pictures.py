"""The hall rover's camera, and the view from above."""

from io import BytesIO
from math import pi

import cv2
import numpy as np
import pytest
from PIL import Image

from robots.kit.drivers.srv1.protocol import QUALITIES, SIZES, Malformed
from simulators.common.mesh import placed
from simulators.srv1.cameras import ABOVE, Overhead, RoverCamera, stage
from simulators.srv1.imaging import jpeg

HOME = placed(1.0, 1.0, 0.0, 0.4)


@pytest.fixture(scope="module")
def camera():
    return RoverCamera(stage())


def difference(a, b):
    return float(np.abs(a.astype(int) - b.astype(int)).mean())


@pytest.mark.parametrize("size", SIZES)
def test_a_picture_is_a_jpeg_of_the_asked_size(camera, size):
    data = jpeg(camera.take(HOME, size.width))
    assert data.startswith(b"\xff\xd8")
    read = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
    assert read.shape == (size.height, size.width, 3)
    assert read.std() > 25, "there is something to see"


def test_there_are_no_other_sizes(camera):
    with pytest.raises(Malformed):
        camera.take(HOME, 333)


def test_two_pictures_of_a_place_differ_a_little_and_places_a_lot(camera):
    one, again = camera.take(HOME), camera.take(HOME)
    assert 0 < difference(one, again) < 5
    assert difference(one, camera.take(placed(10.6, 4.0, 0.0, pi))) > 20


def test_sizes_show_the_same(camera):
    large = cv2.resize(camera.take(HOME, 640), (160, 120), interpolation=cv2.INTER_AREA)
    assert difference(camera.take(HOME, 160), large) < 8


def test_nothing_is_left_out_between_floor_walls_and_ceiling(camera):
    for x, y, heading in ((1.0, 1.0, 0.0), (6.0, 2.3, 1.0), (10.6, 6.45, -2.0), (4.5, 4.0, 3.0)):
        camera.take(placed(x, y, 0.0, heading), 160)
        assert np.isfinite(camera._canvases[160].depth()).all()


def test_a_showcase_that_was_moved_is_seen_where_it_is(camera):
    before = camera.take(placed(1.0, 2.6, 0.0, 0.0))
    gone = camera.take(placed(1.0, 2.6, 0.0, 0.0), moved={"Ammonites": (0.0, 3.0)})
    near = camera.take(placed(1.0, 2.6, 0.0, 0.0), moved={"Ammonites": (-0.5, 0.0)})
    assert difference(before, gone) > 10
    assert difference(before, near) > 10


def test_the_view_from_above_shows_the_rover_where_it_is():
    above = Overhead(stage())
    here, there = above.take(placed(2.0, 4.0, 0.0)), above.take(placed(10.0, 4.0, 0.0))
    assert here.shape == (ABOVE.height, ABOVE.width, 3)
    rows, columns = np.nonzero((here != there).any(-1))
    assert np.abs(rows - ABOVE.height / 2).max() < 12
    left, right = columns[columns < 320], columns[columns > 320]
    assert len(left) > 30
    assert len(right) > 30
    assert right.mean() - left.mean() == pytest.approx(8.0 / 12.68 * 640, rel=0.05)


@pytest.mark.parametrize("quality", QUALITIES)
def test_a_quality_has_the_tables_of_the_rovers_encoder(camera, quality):
    """The firmware multiplies the standard's tables by (3 * quality - 2) / 8."""
    first, *_ = Image.open(BytesIO(jpeg(camera.take(HOME), quality))).quantization.values()
    standard = (16, 11, 10, 16, 24, 40, 51, 61)  # the first row
    assert first[:8] == pytest.approx([max(2, n * (3 * quality - 2) / 8) for n in standard], abs=1.5)


def test_a_better_quality_is_larger_and_nearer_to_what_is_seen(camera):
    taken = camera.take(HOME)
    sent = [jpeg(taken, quality) for quality in QUALITIES]
    assert sorted(sent, key=len, reverse=True) == sent
    assert len(sent[0]) > 3 * len(sent[-1])
    read = [cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)[:, :, ::-1] for data in sent]
    assert difference(read[0], taken) < difference(read[3], taken) < difference(read[-1], taken)
