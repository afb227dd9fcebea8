"""Light in the simulated camera: brightness follows the exposure, what gleams draws streaks (section 6.6)."""

import numpy as np
import pytest

from robots.kit.drivers.mercury.beds import FIRST
from robots.kit.drivers.mercury.brightness import TARGET, Brightness
from simulators.mercury.camera import expose
from tests.unit.sand_beds import fresh

EXPOSURES = (1 / 200, 1 / 150, 1 / 100, 1 / 64)
X_MM, Y_MM = FIRST["watch"]
AT = (X_MM / 1000, Y_MM / 1000, 0.0, 0.0)


@pytest.fixture(scope="module")
def bed():
    return fresh(3)


@pytest.fixture(scope="module")
def bare():
    """Sand with the watch uncovered."""
    bed = fresh(3)
    for _ in range(10):
        for dx, dy in ((-9, 10), (9, 10), (9, -9), (-9, -9), (0, 0)):
            bed.blow(X_MM + dx, Y_MM + dy, 0.2)
    return bed


def shot(bed, pose, exposure):
    return expose(bed, [pose], exposure, np.random.default_rng(1)).astype(float)


def test_brightness_follows_the_exposure(bed):
    """Twice the time is twice the light, from 1/200 to 1/64 s, until the picture is white."""
    pictures = {e: shot(bed, (0.0, 0.42, 0.075, 0.0), e) for e in EXPOSURES}
    longest = pictures[EXPOSURES[-1]]
    inside = longest < 245
    assert inside.mean() > 0.9
    for exposure, picture in pictures.items():
        ratio = float(picture[inside].mean() / longest[inside].mean())
        assert ratio == pytest.approx(exposure * 64, rel=0.02)


def test_no_exposure_of_the_camera_shows_plain_sand_white_or_black(bed):
    for exposure in EXPOSURES:
        picture = shot(bed, (0.0, 0.42, 0.075, 0.0), exposure)
        assert (picture > 250).mean() < 0.01
        assert (picture < 8).mean() < 0.01


def test_the_delivered_picture_is_lifted_to_an_even_grey(bed):
    picture = shot(bed, (0.0, 0.42, 0.075, 0.0), 1 / 150).astype(np.uint8)
    shown, state = Brightness().correct(picture)
    assert abs(float(np.median(shown)) - TARGET) < 15
    again, _ = state.correct(picture)
    assert abs(float(again.mean()) - float(shown.mean())) < 2, "the first picture does not differ from the second"


def streak_px(bare, exposure):
    """Return in how many rows the brightest column is lighter than the columns beside it."""
    shown = shot(bare, AT, exposure)
    column = int(np.argmax((shown >= 254).sum(0)))
    beside = np.r_[column - 16 : column - 9, column + 10 : column + 17]
    lighter = shown[:, column] - np.median(shown[:, beside], axis=1)
    return int((lighter > 12).sum())


def test_what_gleams_draws_a_streak_along_its_column_the_longer_the_exposure(bare, bed):
    short, long = (streak_px(bare, e) for e in (1 / 150, 1 / 64))
    assert long > 1.5 * short
    assert long > 100, "over most of the picture's 165 rows"


def test_sand_and_paper_draw_none(bed):
    for exposure in (1 / 150, 1 / 64):
        picture = shot(bed, (0.0, 0.42, 0.0, 0.0), exposure)
        columns = picture.mean(0)
        assert np.abs(columns - np.convolve(columns, np.ones(9) / 9, "same"))[8:-8].max() < 6
