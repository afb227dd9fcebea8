"""Docking: equation (1), and a robot on paper that comes from everywhere and mates."""

import math
import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.kit.rovers.docking import REST, Docking, DockLimits, Sighting, dock, x_desired

KEPT = DockLimits()
HALF_VIEW = math.tan(math.radians(55))
CAMERA_M, DOCKED_M, DT = 0.07, 0.1026, 0.1
sightings = st.builds(Sighting, st.floats(-1, 1), st.floats(0.03, 2), st.floats(-1.5, 1.5))
docking = st.builds(
    Docking,
    phase=st.sampled_from(["approach", "final", "reverse", "look", "gone", "charging"]),
    phase_s=st.floats(0, 100),
    unseen_s=st.floats(0, 100),
    side=st.sampled_from([-1.0, 1.0]),
    tries=st.integers(0, 5),
    thetas=st.lists(st.floats(-1.5, 1.5), max_size=25).map(tuple),
)


def test_equation_1():
    """By hand: x 0.2 at 0.5 m is 0.4 a metre; a fiftieth of maxX/Z; 6 degrees are a fifth of maxθ."""
    seen = Sighting(0.2, 0.5, math.radians(6))
    assert x_desired(seen, KEPT) == pytest.approx(-abs(0.02 - 0.2))
    assert x_desired(Sighting(0.2, 0.5, math.radians(-6)), KEPT) == pytest.approx(0.18)
    assert x_desired(Sighting(0.9, 0.5, 0.0), KEPT) == 0.0  # sign(0) = 0


@given(sightings)
def test_the_marker_stays_whole_in_the_picture_and_left_and_right_are_alike(seen):
    assert abs(x_desired(seen, KEPT)) <= KEPT.edge
    assert x_desired(Sighting(-seen.x, seen.z, -seen.theta), KEPT) == pytest.approx(-x_desired(seen, KEPT))


@given(st.none() | sightings, st.none() | sightings, st.booleans(), docking, st.floats(0, 1))
def test_speeds_are_bounded_and_charging_is_rest(outer, small, charging, memory, dt):
    velocity, after = dock(outer, small, charging, memory, dt)
    assert -KEPT.back <= velocity.v <= KEPT.fast and abs(velocity.w) <= KEPT.turn
    assert (after.phase == "charging" and velocity == REST) if charging else after.phase != "charging"
    assert after.tries - memory.tries in (0, 1)


@pytest.mark.parametrize("bad", [Sighting(math.nan, 1, 0), Sighting(0, 1e308, 0), Sighting(0, 0, 0), Sighting(0, 1, math.inf)])  # fmt: skip
def test_what_no_camera_sees_is_refused(bad):
    for outer, small in ((bad, None), (None, bad)):
        with pytest.raises(ValueError, match="no camera"):
            dock(outer, small, False, Docking(), DT)
    with pytest.raises(ValueError, match="dt"):
        dock(None, None, False, Docking(), math.nan)


def test_the_small_marker_alone_is_driven_at_straight():
    velocity, memory = dock(None, Sighting(0.2, 0.05, 0.3), False, Docking(), DT)
    assert memory.phase == "final"
    assert velocity.w == pytest.approx(-0.2) and velocity.v == KEPT.slow


def test_without_current_it_reverses_and_comes_again():
    """Bent contacts: the robot stands at the stop and sees the small marker; nothing says charging."""
    memory, phases = Docking(), []
    for _ in range(300):
        velocity, memory = dock(None, Sighting(0.0, 0.033, 0.0), False, memory, DT)
        phases.append(memory.phase)
        assert (velocity.v < 0) == (memory.phase == "reverse" and velocity != REST)
    assert memory.tries >= 2 and {"final", "reverse"} == set(phases) - {"approach"}


def test_a_dock_that_is_not_seen_is_looked_for_once_around_and_then_gone():
    memory, turned = Docking(), 0.0
    for _ in range(200):
        velocity, memory = dock(None, None, False, memory, DT)
        turned += abs(velocity.w) * DT
        assert velocity.v == 0
    assert memory.phase == "gone" and turned > 2 * math.pi


def test_a_marker_that_comes_back_ends_the_search():
    memory = Docking(phase="gone")
    _, memory = dock(Sighting(0.1, 0.5, 0.1), None, False, memory, DT)
    assert memory.phase == "approach"


def sight(x, y, heading, side, dice):
    """Return what a camera sees of a marker of a side (m) from a robot's place in the dock's frame; None if not whole."""
    cx, cy = x + CAMERA_M * math.cos(heading), y + CAMERA_M * math.sin(heading)
    spots = []
    for edge in (-side / 2, 0.0, side / 2):
        ahead = -cx * math.cos(heading) + (edge - cy) * math.sin(heading)
        left = cx * math.sin(heading) + (edge - cy) * math.cos(heading)
        if ahead < 0.02 or abs(left / ahead / HALF_VIEW) > 1 or side / 2 / ahead > 0.82:
            return None
        spots.append((-left / ahead / HALF_VIEW, ahead))
    z, theta = spots[1][1], math.atan2(-cy, cx)
    if abs(theta) > 1.1 or side / z < 0.045 or dice.random() < (0.3 if z > 1 else 0.05):
        return None
    theta = theta * (-1 if dice.random() < 0.2 * z else 1) + dice.gauss(0, math.radians(2 + 4 * z))
    return Sighting(spots[1][0] + dice.gauss(0, 0.01), z * (1 + dice.gauss(0, 0.03)), max(-1.5, min(theta, 1.5)))


def mated(x, y, heading, dice):
    """Return the failed tries until both contacts touch, None if more than two or the dock was lost."""
    memory, v = Docking(), 0.0
    for _ in range(1500):
        off = abs(math.remainder(heading - math.pi, 2 * math.pi))
        charging = x <= DOCKED_M + 0.001 and abs(y) < 0.01 and off < 0.2
        outer, small = (sight(x, y, heading, side, dice) for side in (0.075, 0.012))
        velocity, memory = dock(outer, small, charging, memory, DT)
        if charging:
            return memory.tries
        if memory.phase == "gone" or memory.tries > 2:
            return None
        v += max(-0.05, min(velocity.v - v, 0.05))
        heading += velocity.w * DT
        x, y = max(x + v * DT * math.cos(heading), DOCKED_M), y + v * DT * math.sin(heading)
        if x < 0.19 and abs(y) < 0.05:  # between the guides
            y = max(-0.008, min(y, 0.008))
    return None


def from_thirty_random_places(seed):
    dice, found = random.Random(seed), []
    while len(found) < 30:
        distance, angle = dice.uniform(0.3, 1.5), math.radians(dice.uniform(-55, 55))
        x, y = distance * math.cos(angle), distance * math.sin(angle)
        heading = math.atan2(-y, -x) + dice.uniform(-0.8, 0.8)
        if sight(x, y, heading, 0.075, random.Random(1)):
            found.append(mated(x, y, heading, dice))
    return found


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_from_thirty_random_places_it_mates_within_three_tries_and_most_often_at_the_first(seed):
    """As the published test, which ended well from most places; with a marker that tells angles badly from afar."""
    found = from_thirty_random_places(seed)
    assert sum(tries is not None for tries in found) >= 29
    assert sum(tries == 0 for tries in found) >= 27
