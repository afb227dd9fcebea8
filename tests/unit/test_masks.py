"""Privacy masks: what is refused, what is black, and that a picture which cannot be judged shows nothing."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.kit.contract.errors import BadRequest
from robots.kit.vision.masks import check, masked, masks_of

PICTURE = np.full((24, 32, 3), 200, np.uint8)


@pytest.mark.parametrize(
    "wrong",
    [
        "x", {}, [1], [[0, 0, 0, 1]], [[0, 0, 0, 0, 1]], [[0, 5, 0, 4, 1]], [[-1, 0, 0, 1, 1]], [[16, 0, 0, 1, 1]],
        [[0, 0, 0, 1.5, 1]], [[0, 0, 0, True, 1]], [[0, 0, 0, 10**400, 1]], [[0, -1, 0, 1, 1]], [[0, 0, 0, 1, 1]] * 33,
    ],
)  # fmt: skip
def test_what_is_no_list_of_masks_is_refused_and_never_shows_more(wrong):
    with pytest.raises(BadRequest):
        check(wrong)
    assert not masked(PICTURE, masks_of({"privacy_masks": wrong}, 0)).any(), "rather nothing than too much"


def test_each_camera_has_masks_of_its_own():
    settings = {"privacy_masks": [[0, 2, 3, 10, 8], [1, 0, 0, 5, 5]]}
    shown = masked(PICTURE, masks_of(settings, 0))
    assert not shown[3:8, 2:10].any() and shown.sum() == PICTURE.sum() - 5 * 8 * 3 * 200
    assert (PICTURE == 200).all(), "the source's own picture is left alone"
    assert masked(PICTURE, masks_of(settings, 2)) is PICTURE and masks_of({}, 0) == ()


@given(st.lists(st.tuples(st.integers(0, 50), st.integers(0, 50), st.integers(1, 99), st.integers(1, 99)), max_size=5))
def test_all_of_a_mask_is_black_and_nothing_else(corners):
    masks = [(x, y, x + w, y + h) for x, y, w, h in corners]
    shown = masked(PICTURE[:, :, 0], masks_of({"privacy_masks": [[0, *mask] for mask in masks]}, 0))
    for y in range(24):
        for x in range(32):
            inside = any(x0 <= x < x1 and y0 <= y < y1 for x0, y0, x1, y1 in masks)
            assert shown[y, x] == (0 if inside else 200)
