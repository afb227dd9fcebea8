"""Markers of 3 x 3 bits: read from seven pixels on, placed, and not seen where there are none."""

import math

import cv2
import numpy as np
import pytest

from robots.kit.vision.markers import Markers
from tests.unit.ratslam_world import World, laps

FIELD = math.radians(110)
WIDTH, HEIGHT, FOCAL = 416, 240, 208 / math.tan(FIELD / 2)
OUTER_M, SMALL_M, BOARD_M = 0.075, 0.012, 0.15
OUTER = ((1, 1, 1), (0, 1, 0), (0, 0, 1))
SMALL = ((1, 0, 1), (0, 0, 1), (0, 1, 0))
DARK = ((1, 1, 1), (0, 0, 0), (0, 0, 1))  # the outer one as it reads when the small one darkens its centre
FINDER = Markers({0: OUTER, 1: DARK, 2: SMALL}, {0: OUTER_M, 1: OUTER_M, 2: SMALL_M}, FIELD, frozenset({2}))


def board(side=1200):
    """Return the small marker in the centre cell of the outer one, on white."""
    made = np.full((side, side), 250, np.uint8)
    for bits, metres in ((OUTER, OUTER_M), (SMALL, SMALL_M)):
        code = np.zeros((5, 5), np.uint8)
        code[1:4, 1:4] = np.array(bits) * 250
        size = round(metres / BOARD_M * side)
        at = (side - size) // 2
        made[at : at + size, at : at + size] = cv2.resize(code, (size, size), interpolation=cv2.INTER_NEAREST)
    return made


BOARD = board()


def shot(distance, angle, turned, dice):
    """Return the picture of a camera at a distance (m) and angle (rad, left of the axis) that looks `turned` past it."""
    by, half = 4, BOARD_M / 2
    x, y = distance * math.cos(angle), -distance * math.sin(angle)  # x out of the board, y left as seen from it
    heading = math.atan2(-y, -x) + turned
    ends = []
    for side, high in ((-half, half), (half, half), (half, -half), (-half, -half)):
        ahead = -x * math.cos(heading) + (side - y) * math.sin(heading)
        left = x * math.sin(heading) + (side - y) * math.cos(heading)
        ends.append(((WIDTH / 2 - left / ahead * FOCAL) * by, (HEIGHT / 2 - high / ahead * FOCAL) * by))
    begins = np.array([(0, 0), (1200, 0), (1200, 1200), (0, 1200)], np.float32)
    onto = cv2.getPerspectiveTransform(begins, np.array(ends, np.float32))
    large = cv2.warpPerspective(BOARD, onto, (WIDTH * by, HEIGHT * by), flags=cv2.INTER_AREA, borderValue=110)
    grey = cv2.resize(large, (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA) + dice.normal(0, 2, (HEIGHT, WIDTH))
    jpeg = cv2.imencode(".jpg", np.clip(grey, 0, 255).astype(np.uint8), [cv2.IMWRITE_JPEG_QUALITY, 60])[1]
    return cv2.imdecode(jpeg, cv2.IMREAD_GRAYSCALE)


def test_seven_pixels_suffice():
    """At 1.6 m the outer marker is 6.8 pixels wide; the published robot saw it from there."""
    dice = np.random.default_rng(1)
    seen = 0
    for _ in range(24):
        found = FINDER.find(shot(1.6, dice.uniform(-0.3, 0.3), dice.uniform(-0.3, 0.3), dice))
        seen += any(marker.number < 2 and marker.sighting.z == pytest.approx(1.55, abs=0.15) for marker in found)
    assert seen >= 18


@pytest.mark.parametrize("distance", [0.1, 0.2, 0.5, 0.8])
def test_a_marker_is_placed(distance):
    dice, off, angles = np.random.default_rng(2), [], []
    for _ in range(8):
        angle, turned = dice.uniform(-0.2, 0.2), dice.uniform(-0.2, 0.2)
        outer = next(m for m in FINDER.find(shot(distance, angle, turned, dice)) if m.number < 2)
        assert outer.sighting.z == pytest.approx(distance * math.cos(turned), rel=0.04)
        assert outer.sighting.x == pytest.approx(math.tan(turned) / math.tan(FIELD / 2), abs=0.02)
        off.append(outer.sighting.theta - angle)
        angles.append(angle)
    assert np.median(np.abs(off)) < math.radians(8)
    assert distance > 0.3 or np.corrcoef(angles, np.array(off) + angles)[0, 1] > 0.8  # left of the axis is positive


@pytest.mark.parametrize(("distance", "numbers"), [(0.035, {2}), (0.06, {0, 2}), (0.1, {0, 2}), (0.5, {0})])
def test_the_small_marker_hides_the_outer_one_only_where_that_is_larger_than_the_picture(distance, numbers):
    dice = np.random.default_rng(3)
    for turned in (-0.05, 0.0, 0.05):
        found = FINDER.find(shot(distance, 0.03, turned, dice))
        assert {0 if marker.number == 1 else marker.number for marker in found} == numbers


def test_walls_with_patterns_are_no_markers():
    world, dice = World(), np.random.default_rng(4)
    for x, y, facing, _, _ in list(laps(1))[::40]:
        assert FINDER.find(world.picture(x, y, facing)) == []
    for _ in range(20):
        blocks = (dice.random((24, 42)) > 0.5).astype(np.uint8) * 200 + 20
        assert FINDER.find(cv2.resize(blocks, (WIDTH, HEIGHT), interpolation=cv2.INTER_NEAREST)) == []


def test_another_marker_is_not_ours():
    """The same size and border, one bit different, as on a thing that somebody put in the maze."""
    other = Markers({0: ((1, 1, 1), (0, 1, 0), (1, 0, 1))}, {0: OUTER_M}, FIELD)
    picture = shot(0.3, 0.0, 0.0, np.random.default_rng(5))
    assert FINDER.find(picture) and other.find(picture) == []


@pytest.mark.parametrize(
    "picture", [np.zeros((240, 416, 3), np.uint8), np.zeros((240, 416)), np.zeros((2, 2), np.uint8)]
)
def test_what_is_no_grey_picture_is_refused(picture):
    with pytest.raises(ValueError, match="grey picture"):
        FINDER.find(picture)


def test_a_code_without_a_size_is_refused():
    with pytest.raises(ValueError, match="side"):
        Markers({0: OUTER}, {}, FIELD)
    with pytest.raises(ValueError, match="square"):
        Markers({0: OUTER, 1: ((1, 0), (0, 1))}, {0: 0.1, 1: 0.1}, FIELD)
