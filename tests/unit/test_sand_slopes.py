"""Sand slides to its angle of repose, whichever way the slope looks, and none is made or lost on the way."""

import numpy as np
import pytest
from scipy.ndimage import map_coordinates

from simulators.mercury.sand import LEVEL_MM, X0_MM, Y0_MM
from simulators.mercury.slide import REPOSE
from tests.unit.sand_beds import fresh

REPOSE_DEG = float(np.degrees(np.arctan(REPOSE)))
DIRECTIONS = np.arange(16) * np.pi / 8
ROW, COLUMN = 420 - Y0_MM, 60 - X0_MM  # nothing lies buried there


@pytest.fixture
def flat():
    """Return a level bed of deep sand without anything in it."""
    bed = fresh(2)
    bed.sand[:] = LEVEL_MM + 30
    bed.rigid[:] = 0
    return bed


def volume(bed):
    return float(bed.sand.sum(dtype=np.float64))


def steepest_deg(bed):
    """Return the steepest slope by central differences, a few single cells of a rim left out."""
    slope = np.sort(np.hypot(*np.gradient(bed.sand.astype(float))).ravel())
    assert np.degrees(np.arctan(slope[-1])) < REPOSE_DEG + 4
    return float(np.degrees(np.arctan(slope[-30])))


def slopes_deg(bed, near, far):
    """Return the slope along a ray in 16 directions from the middle, between two distances (mm); up is positive."""
    d = np.arange(near, far)
    found = []
    for way in DIRECTIONS:
        h = map_coordinates(bed.sand.astype(float), [ROW + d * np.sin(way), COLUMN + d * np.cos(way)], order=1)
        found.append(np.degrees(np.arctan(np.polyfit(d, h, 1)[0])))
    return np.array(found)


def test_a_heap_is_a_cone(flat):
    yy, xx = np.mgrid[0 : flat.sand.shape[0], 0 : flat.sand.shape[1]]
    flat.sand += (60 * np.exp(-((np.hypot(yy - ROW, xx - COLUMN) / 8) ** 2))).astype(np.float32)
    before = volume(flat)
    flat.relax(ROW - 20, ROW + 20, COLUMN - 20, COLUMN + 20)
    slopes = -slopes_deg(flat, 4, 16)
    assert np.abs(slopes - REPOSE_DEG).max() < 1.5, slopes
    assert slopes.max() - slopes.min() < 2.0, slopes
    assert steepest_deg(flat) < REPOSE_DEG + 1.5
    assert abs(volume(flat) - before) < before * 1e-7


def test_a_crater_is_a_cone(flat):
    before = volume(flat)
    for _ in range(14):
        flat.blow(60, 420, 0.15)
    slopes = slopes_deg(flat, 6, 18)
    assert np.abs(slopes - REPOSE_DEG).max() < 2.5, slopes
    assert slopes.max() - slopes.min() < 2.0, slopes
    assert steepest_deg(flat) < REPOSE_DEG + 1.5
    assert abs(volume(flat) - before) < before * 1e-6


def test_a_slide_goes_on_beyond_where_it_began(flat):
    """A heap far larger than the window that was asked for comes to rest as a whole."""
    yy, xx = np.mgrid[0 : flat.sand.shape[0], 0 : flat.sand.shape[1]]
    flat.sand += (90 * np.exp(-((np.hypot(yy - ROW, xx - COLUMN) / 40) ** 2))).astype(np.float32)
    flat.relax(ROW - 5, ROW + 5, COLUMN - 5, COLUMN + 5)
    assert steepest_deg(flat) < REPOSE_DEG + 1.5


def test_real_sand_with_its_ripples_keeps_the_angle_too():
    bed = fresh(2)
    before = volume(bed)
    for x, y in ((60, 420), (66, 424), (-200, 430), (-195, 441)):
        for _ in range(6):
            bed.blow(x, y, 0.15)
    hidden = bed.sand - bed.rigid > 3  # on a thing, its own edge is steeper than sand may be
    slope = np.degrees(np.arctan(np.hypot(*np.gradient(bed.sand.astype(float)))))
    assert slope[hidden].max() < REPOSE_DEG + 3.5
    assert abs(volume(bed) - before) < before * 1e-6
    assert (bed.sand >= bed.rigid - 1e-3).all()
