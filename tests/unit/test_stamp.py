"""The time that simulators paint into their pictures."""

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from simulators.common import stamp

SIZES = ((165, 192), (240, 416, 3), (16, 96), (480, 640, 3))


@given(st.integers(0, 1 << 45), st.sampled_from(SIZES), st.integers(20, 100), st.integers(0, 255))
def test_a_stamp_is_read_again_after_any_jpeg(ms, size, quality, shade):
    picture = np.random.default_rng(shade).integers(0, 256, size).astype(np.uint8)
    stamped = stamp.painted(picture, ms)
    assert stamped.shape == picture.shape
    done, data = cv2.imencode(".jpg", stamped, [cv2.IMWRITE_JPEG_QUALITY, quality])
    assert done
    again = np.asarray(cv2.imdecode(data, cv2.IMREAD_UNCHANGED), np.uint8)
    assert stamp.read(again) == ms % stamp.WRAP_MS


@pytest.mark.parametrize("shade", [0, 255])
@pytest.mark.parametrize("size", [*SIZES, (8, 96)])
def test_a_picture_of_one_shade_has_no_stamp(shade, size):
    assert stamp.read(np.full(size, shade, np.uint8)) is None


def test_a_picture_that_is_too_small_is_refused():
    with pytest.raises(ValueError, match="96 x 16"):
        stamp.painted(np.zeros((15, 96), np.uint8), 1)
