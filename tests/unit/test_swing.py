"""How an object swings on threads is fitted to where it was seen when."""

import numpy as np
import pytest

from robots.kit.arms.swing import fitted, height

LENGTH, RATE = 1.7, np.sqrt(9.81 / 1.7)


def places(times, far, phase, way=(0.0, 1.0), noise=0.0):
    dice = np.random.default_rng(1)
    along = far * np.cos(RATE * times - phase)
    seen = np.array([0.55, 0.30]) + along[:, None] * np.array(way)
    return seen + noise * dice.normal(size=seen.shape)


@pytest.mark.parametrize("phase", [0.0, 1.0, 2.5, 4.0, 6.0])
@pytest.mark.parametrize("far", [0.01, 0.05, 0.08])
def test_a_swing_is_told_from_a_few_places_of_three_quarters_of_it(far, phase):
    times = 1000.0 + np.arange(0.0, 2.0, 0.2)
    swing = fitted(times, places(times, far, phase, noise=0.0005), LENGTH)
    assert swing.far == pytest.approx(far, abs=0.001)
    assert swing.middle == pytest.approx([0.55, 0.30], abs=0.001)
    assert abs(swing.way[1]) > 0.99
    assert swing.off < 0.001
    for after in (1002.0, 1002.9, 1004.4):
        time, place = swing.turns(after)
        assert after <= time < after + np.pi / RATE + 1e-9
        assert place == pytest.approx(places(np.array([time]), far, phase)[0], abs=0.0015)
        assert swing.at(time) == pytest.approx(place, abs=1e-9)
        assert abs((swing.at(time + 0.01) - swing.at(time - 0.01)) @ swing.way) < 1e-6, "it is slowest there"


def test_what_moves_otherwise_is_no_swing_and_few_places_tell_none():
    times = np.arange(0.0, 2.0, 0.2)
    odd = places(times, 0.05, 0.0)
    odd[5:, 1] += 0.06
    assert fitted(times, odd, LENGTH).off > 0.01
    assert fitted(times[:3], odd[:3], LENGTH) is None


def test_what_hangs_aside_is_higher():
    rest = np.array([0.55, 0.30, 0.30])
    assert height(LENGTH, rest, rest) == pytest.approx(0.30)
    assert height(LENGTH, rest, rest + np.array([0.0, 0.1, 0.0])) == pytest.approx(
        0.30 + 0.1**2 / (2 * LENGTH), abs=1e-4
    )
    assert height(LENGTH, rest, rest + np.array([9.0, 0.0, 0.0])) == pytest.approx(0.30 + LENGTH)
