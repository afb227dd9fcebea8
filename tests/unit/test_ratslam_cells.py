"""Pose cells: what stays true of the network, and that it follows the robot."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robots.kit.slam import spreading
from robots.kit.slam.cells import PoseCells
from robots.kit.slam.settings import CellSettings
from robots.kit.slam.stream import activity

KEPT = CellSettings()
moves = st.tuples(st.floats(-0.3, 0.3), st.floats(-7, 7))
places = st.tuples(st.floats(0, 15), st.floats(0, 15), st.floats(0, 36))


def whole_and_positive(cells):
    return (cells >= 0).all() and cells.sum() == pytest.approx(1, abs=1e-9)


@settings(max_examples=40, deadline=None)
@given(st.lists(st.tuples(moves, st.none() | st.tuples(places, st.floats(0, 0.1))), min_size=1, max_size=12))
def test_activity_is_never_negative_and_its_sum_is_one(steps):
    net = PoseCells(KEPT)
    for (distance, turn), injected in steps:
        if injected:
            net.inject(*injected)
        net.step(distance, turn)
        assert whole_and_positive(net.cells)
        assert 0 <= net.best[0] <= 15 and 0 <= net.best[1] <= 15 and 0 <= net.best[2] <= 36


def plainly(cells, width, sd):
    """Spread each cell over its cube of neighbours, as published."""
    half, out = width // 2, np.zeros_like(cells)
    grid = np.indices((width,) * 3) - half
    cube = np.exp(-np.square(grid).sum(axis=0) / (2 * sd * sd))
    cube /= cube.sum()
    for place in np.argwhere(cells):
        k, j, i = np.meshgrid(*[(place[n] + np.arange(-half, half + 1)) % cells.shape[n] for n in range(3)], indexing="ij")  # fmt: skip
        np.add.at(out, (k, j, i), cells[tuple(place)] * cube)
    return out


def test_three_lines_of_weights_are_the_published_cube():
    dice = np.random.default_rng(1)
    cells = np.where(dice.random((36, 15, 15)) < 0.01, dice.random((36, 15, 15)), 0.0)
    cells /= cells.sum()
    expected = plainly(cells, 7, 1.0)
    expected = np.maximum(expected - plainly(expected, 5, 2.0) - KEPT.inhibit_all, 0.0)
    assert spreading.compete(cells, spreading.line(7, 1.0), spreading.line(5, 2.0), KEPT.inhibit_all)
    np.testing.assert_allclose(cells, expected / expected.sum(), atol=1e-12)


@settings(max_examples=35, deadline=None)
@given(st.integers(-40, 40), st.integers(-80, 80))
def test_the_axes_wrap_around(cells, layers):
    """A peak on layer 0 moves along x by whole cells, and turns by whole layers."""
    net = np.zeros((36, 15, 15))
    net[0, 4, 3] = 1.0
    spreading.shift(net, float(cells), float(layers))
    assert net[layers % 36, 4, (3 + cells) % 15] == pytest.approx(1)


@settings(max_examples=35, deadline=None)
@given(st.floats(-3, 3), st.floats(-20, 20), st.integers(0, 2**32 - 1))
def test_moving_loses_no_activity(forward, turn, seed):
    cells = np.random.default_rng(seed).random((36, 15, 15))
    cells /= cells.sum()
    spreading.shift(cells, forward, turn)
    assert whole_and_positive(cells)


@pytest.mark.parametrize(("distance", "turn"), [(0.0075, 0.0), (-0.0075, 0.0), (0.0, 0.1), (0.0, -0.1), (0.003, 0.03)])
def test_the_peak_follows_the_robot_nearly_at_its_speed(distance, turn):
    """The grid holds a slow peak back a little, which is the network's nature: at these speeds by a fifth at most."""
    net, gone = PoseCells(KEPT), np.zeros(3)
    sizes = np.array([15, 15, 36])
    for _ in range(5):
        net.step(0.0, 0.0)
    for _ in range(100):
        before = np.array(net.best)
        net.step(distance, turn)
        gone += (np.array(net.best) - before + sizes / 2) % sizes - sizes / 2
    if not turn:  # the robot begins on layer 18, so it faces against x
        assert 0.8 < -gone[0] * KEPT.cell_m / (100 * distance) < 1.05
    assert gone[2] * 2 * math.pi / 36 == pytest.approx(100 * turn, rel=0.2)


def test_the_peak_stays_while_the_robot_rests():
    net = PoseCells(KEPT)
    for _ in range(300):
        net.step(0.0, 0.0)
    assert net.best == pytest.approx((7, 7, 18), abs=1e-6)


def test_repeated_injection_wins_over_the_old_peak():
    """One injection does not move the robot's belief; ten of the published energy do."""
    net, there = PoseCells(KEPT), (2.0, 12.0, 30.0)
    for n in range(10):
        net.inject(there, KEPT.inject)
        net.step(0.0, 0.0)
        if n == 0:
            assert net.distances(np.array([there]))[0] > 5
    assert net.distances(np.array([there]))[0] < 0.5


@given(st.floats(0, 15), st.floats(0, 15), st.floats(0, 36))
@settings(max_examples=50, deadline=None)
def test_injected_energy_has_its_centre_at_the_place(x, y, heading):
    net = PoseCells(KEPT)
    net.cells[:] = 0.0
    net.inject((x, y, heading), 0.5)
    assert net.cells.sum() == pytest.approx(0.5)
    net.best = tuple(spreading.peak(net.cells, 3))
    assert net.distances(np.array([(x, y, heading)]))[0] < 0.05


def test_activity_that_is_spread_evenly_stays_and_is_no_division_by_zero():
    net = PoseCells(KEPT)
    net.cells[:] = 1 / net.cells.size
    net.step(0.01, 0.1)
    assert whole_and_positive(net.cells)


def test_the_streamed_activity_is_that_of_the_cells():
    net = PoseCells(KEPT)
    for _ in range(30):
        net.step(0.004, 0.02)
    numbers, levels = activity(net.cells)
    flat = net.cells.reshape(-1)
    assert levels.max() == 255 and numbers[levels.argmax()] == flat.argmax()
    assert (np.abs(levels / 255 - flat[numbers] / flat.max()) <= 0.5 / 255 + 1e-9).all()
    left_out = np.delete(flat, numbers)
    assert left_out.max() < flat.max() / 64
    assert 3 * len(numbers) < 1500
