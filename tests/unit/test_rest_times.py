"""The longest time to rest without a word that a spec states is no shorter than what the robot's controller takes."""

from math import pi

import pytest

from robots.kit.contract.find import spec_of
from robots.kit.description import load
from simulators.common.tcp import LOST_S
from simulators.mercury.arm import Line, Pose

STEP_S = 0.001


@pytest.mark.parametrize("end", [Pose(0.24, 0.55, 0.075, 0.0), Pose(-0.24, 0.29, 0.0, 2 * pi)])
def test_the_longest_motion_of_the_mercury_arm_at_its_lowest_speed(end):
    slowest = load("mercury")["motion"]["speed_range"][0]
    line, taken, ended = Line(Pose(-0.24, 0.29, 0.0, 0.0), end, slowest), 0.0, False
    while not ended:
        _, ended = line.advance(STEP_S)
        taken += STEP_S
    assert taken <= spec_of("mercury").rest_s


def test_the_museum_arms_watchdog_and_its_dead_line():
    first, again, times = LOST_S
    assert spec_of("pa10").rest_s >= max(load("pa10")["line"]["watchdog_s"], first + again * times) + 2.0
