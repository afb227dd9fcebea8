"""View templates: the pruned comparison is the plain one, and pictures that show nothing are told apart."""

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robots.kit.slam.settings import ViewSettings
from robots.kit.slam.views import Views, decoded
from tests.unit.ratslam_world import World, laps

SMALL = ViewSettings(width=16, height=5, shift=3, bottom=60)


def plainly(view, templates, kept):
    """Return (number, difference) of the best template by looking at everything; -1 beyond the threshold."""
    span = kept.width - 2 * kept.shift
    middle = view[:, kept.shift : kept.shift + span].astype(int)
    found = [
        min(int(np.abs(middle - t[:, s : s + span].astype(int)).sum()) for s in range(2 * kept.shift + 1))
        for t in templates
    ]
    full = 255 * kept.height * span
    limit = int(kept.match * full)
    if not found or min(found) > limit:
        return -1, (limit + 1) / full
    return int(np.argmin(found)), min(found) / full


@settings(max_examples=70, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    count=st.integers(0, 40),
    levels=st.sampled_from([2, 4, 32, 256]),
    match=st.sampled_from([0.0, 0.03, 0.2, 0.5, 1.0]),
    guess=st.integers(-3, 45),
)
def test_the_pruned_match_is_the_plain_one_for_any_guess(seed, count, levels, match, guess):
    """Few grey levels make equals frequent; then the lowest number is the answer."""
    kept = ViewSettings(width=16, height=5, shift=3, match=match)
    dice, views = np.random.default_rng(seed), Views(kept)
    grey = (dice.integers(0, levels, (count + 1, 5, 16)) * (255 // (levels - 1))).astype(np.uint8)
    if count > 3:
        grey[count // 2] = grey[0]
        grey[-1] = np.clip(grey[1].astype(int) + dice.integers(-3, 4, (5, 16)), 0, 255)
    for template in grey[:-1]:
        views.add(template, (0.0, 0.0, 0.0), 1.0)
    assert views.match(grey[-1], guess) == plainly(grey[-1], grey[:-1], kept)


def test_the_pruned_match_is_the_plain_one_on_a_drive():
    world, kept = World(), ViewSettings(match=0.1)
    views = Views(kept)
    for x, y, facing, _, _ in list(laps(1))[::25]:
        view = views.view(world.picture(x, y, facing))
        assert views.match(view) == plainly(view, views.templates[: views.count], kept)
        views.add(view, (0.0, 0.0, 0.0), 1.0)
    assert views.count > 30


def test_a_view_shifted_by_up_to_four_columns_is_the_same_and_by_more_is_another():
    dice = np.random.default_rng(3)
    wide = dice.integers(0, 256, (20, 80)).astype(np.uint8)
    views = Views(ViewSettings())
    views.add(wide[:, 10:70], (0.0, 0.0, 0.0), 1.0)
    for columns in range(-4, 5):
        assert views.match(np.ascontiguousarray(wide[:, 10 + columns : 70 + columns])) == (0, 0.0)
    for columns in (-6, 6):
        assert views.match(np.ascontiguousarray(wide[:, 10 + columns : 70 + columns]))[0] == -1


def test_templates_of_any_number_are_kept_and_dropped_in_order():
    dice, views = np.random.default_rng(4), Views(SMALL)
    grey = dice.integers(0, 256, (150, 5, 16)).astype(np.uint8)
    for n, template in enumerate(grey):
        assert views.add(template, (float(n), 0.0, 0.0), 1.0) == n
    views.keep(np.array([3, 70, 149]))
    assert [views.match(grey[n])[0] for n in (3, 70, 149, 4)] == [0, 1, 2, -1]
    assert views.places[:3, 0].tolist() == [3, 70, 149]


def test_a_picture_comes_from_a_jpeg_and_only_its_upper_rows_count():
    picture = World().picture(-0.8, -0.77, 0.0)
    grey = decoded(cv2.imencode(".jpg", picture)[1].tobytes())
    assert grey.shape == (240, 416)
    views = Views(ViewSettings())
    views.add(views.view(picture), (0.0, 0.0, 0.0), 1.0)
    grey[150:] = 255
    assert views.match(views.view(grey))[0] == 0


@pytest.mark.parametrize("jpeg", [b"", b"no picture", b"\xff\xd8\xff\xe0" + bytes(100), bytes(2_000_000)])
def test_what_is_no_jpeg_is_refused(jpeg):
    with pytest.raises(ValueError, match="picture"):
        decoded(jpeg)


@pytest.mark.parametrize(
    "picture", [np.zeros((240, 416, 3), np.uint8), np.zeros((240, 416)), np.zeros((5, 5), np.uint8)]
)
def test_what_is_no_grey_picture_is_refused(picture):
    with pytest.raises(ValueError, match="picture"):
        Views(ViewSettings()).view(picture)
