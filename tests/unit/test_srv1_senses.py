"""What the hall rover's sensors say, against the geometry of the hall."""

from itertools import pairwise
from math import atan2, cos, degrees, hypot, pi, sin

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from robots.kit.description import load
from robots.kit.drivers.srv1.hall import hall
from robots.kit.drivers.srv1.sensors import Channel, infrared_m, is_present, share, temperature_c
from simulators.srv1.climate import VISIT_S, Climate
from tests.unit.rover_worlds import drive, poses, rest, srv1

HALL = hall()
KNOWN = load("srv1")
METEORITE = next(case for case in HALL.cases if case.black)
BEFORE_BLACK = (METEORITE.at[0], METEORITE.at[1] - METEORITE.half[1] - 0.4, pi / 2)
SIGMAS = 6.0


@pytest.fixture(scope="module")
def one():
    return srv1()


def sensor(pose, name):
    x, y, heading = pose
    ahead = KNOWN[name]["from"][0]
    return x + cos(heading) * ahead, y + sin(heading) * ahead


def within(read, true, known):
    """Tell whether a sensor may read this where the truth is that (m)."""
    true = min(max(true, known["near"]), known["far"])
    return known["near"] <= read <= known["far"] and abs(read - true) <= SIGMAS * known["noise"] + 1e-6


@settings(max_examples=200)
@given(pose=poses())
def test_infrared_reads_the_surface_ahead_and_far_at_black_glass(one, pose):
    one.plant.put(*pose)
    true, what = HALL.ray(*sensor(pose, "infrared"), pose[2])
    read = one.senses.infrared()
    if what is METEORITE:
        assert read == KNOWN["infrared"]["far"]
    else:
        assert within(read, true, KNOWN["infrared"])


@given(pose=poses())
def test_sonar_reads_the_nearest_surface_in_its_cone(one, pose):
    one.plant.put(*pose)
    known, (x, y) = KNOWN["sonar"], sensor(pose, "sonar")
    read, room = one.senses.sonar(), SIGMAS * known["noise"]
    half = known["half_cone"]
    cone = min(HALL.ray(x, y, pose[2] + angle)[0] for angle in np.linspace(-half, half, 81))
    assert read >= min(max(cone, known["near"]), known["far"]) - room
    assert read >= min(max(HALL.distance(x, y), known["near"]), known["far"]) - room
    assert read <= max(HALL.ray(x, y, pose[2])[0], known["near"]) + room


@given(pose=poses(), offset=st.sampled_from([-1, 1]))
def test_sonar_hears_what_infrared_passes_by(one, pose, offset):
    """Beside the axis and within the cone."""
    known = KNOWN["sonar"]
    edge = HALL.ray(*sensor(pose, "sonar"), pose[2] + offset * known["half_cone"])[0]
    assume(known["near"] < edge < known["far"])
    one.plant.put(*pose)
    assert one.senses.sonar() <= edge + SIGMAS * known["noise"]


def test_black_glass_is_heard_and_not_seen(one):
    one.plant.put(*BEFORE_BLACK)
    assert one.senses.infrared() == KNOWN["infrared"]["far"]
    assert one.senses.sonar() == pytest.approx(0.27, abs=0.15)
    x, y, _ = BEFORE_BLACK
    one.plant.put(x, y + 0.2, -pi / 2)  # the globe is far
    assert one.senses.infrared() == KNOWN["infrared"]["far"]


def test_two_readings_of_a_wall_differ(one):
    one.plant.put(0.5, 2.0, pi)
    for read in (one.senses.infrared, one.senses.sonar, one.senses.compass):
        seen = [read() for _ in range(200)]
        assert len(set(seen)) > 150
    assert np.std([one.senses.infrared() for _ in range(500)]) == pytest.approx(KNOWN["infrared"]["noise"], rel=0.2)
    assert np.std([one.senses.sonar() for _ in range(500)]) == pytest.approx(KNOWN["sonar"]["noise"], rel=0.2)


@given(pose=poses())
def test_the_compass_counts_clockwise_from_north(one, pose):
    one.plant.put(*pose)
    read = one.senses.compass()
    assert 0 <= read < 360
    assert abs((read - (90 - degrees(pose[2])) + 180) % 360 - 180) < 7


def heard(one, count=200):
    """Return what the beacon told of so many readings: ranges and bearings."""
    told = [one.senses.beacon() for _ in range(count)]
    return np.array([reading for reading in told if reading is not None]).reshape(-1, 2)


def test_the_beacon_tells_where_the_rover_is_from_the_tower():
    """With noise, and now and then by a reflection, whose way is longer."""
    one = srv1((2.0, 1.0, 0.7), beacon=True)
    x, y = 2.0 - HALL.tower[0], 1.0 - HALL.tower[1]
    ranges, bearings = heard(one, 2000).T
    assert len(ranges) == 2000
    off = ranges - hypot(x, y)
    assert np.median(off) == pytest.approx(0.0, abs=0.01)
    assert 0.005 < (off > 0.3).mean() < 0.05, "reflections"
    assert off[off < 0.3].std() == pytest.approx(0.05, rel=0.1)
    turned = np.remainder(bearings - atan2(y, x) + pi, 2 * pi) - pi
    assert abs(turned.mean()) < 0.04, "the tower is not turned exactly"
    assert turned.std() == pytest.approx(0.02, rel=0.1)


@given(pose=poses())
def test_the_bearing_of_the_beacon_is_from_minus_to_plus_half_a_turn(pose):
    one = srv1(pose, beacon=True)
    assert all(-pi <= bearing <= pi and away >= 0.0 for away, bearing in heard(one, 3))


def test_a_beacon_that_is_not_there_out_of_view_or_broken_tells_nothing():
    assert len(heard(srv1((2.0, 1.0, 0.7)))) == 0, "the hall has none, unless somebody says so"
    one = srv1((10.95, 4.0, 0.0), beacon=True)
    assert len(heard(one)) == 200
    one.faults.set("beacon_gone")
    assert len(heard(one)) == 0
    one.faults.clear()
    one.plant.put(9.0, 6.1, 0.0)  # a showcase stands between
    assert len(heard(one)) == 0


def test_a_beacon_changes_nothing_else_of_a_rover():
    """Without one the same seed gives the same readings as with one that nobody asks."""
    plain, other = srv1((2.0, 1.0, 0.7)), srv1((2.0, 1.0, 0.7), beacon=True)
    assert [plain.senses.sonar() for _ in range(9)] == [other.senses.sonar() for _ in range(9)]
    plain.senses.beacon()
    other_reading = plain.senses.sonar()
    assert other_reading == other.senses.sonar(), "a beacon that is not there draws no noise"


# encoders


def test_encoders_count_forwards_and_backwards_from_power_on():
    rover = srv1((1.5, 4.0, 0.0))
    drive(rover, 2.0, 0.3)
    rest(rover)
    left, right = rover.senses.encoders()
    a_metre = KNOWN["body"]["ticks"] / (2 * pi * KNOWN["body"]["wheel_radius"])
    assert left == pytest.approx((rover.plant.pose[0] - 1.5) * a_metre, rel=0.02)
    assert abs(left - right) <= 2
    drive(rover, 1.0, -0.3)
    rest(rover)
    assert rover.senses.encoders()[0] < left - 100
    rover.senses.power_on()
    assert rover.senses.encoders() == (0, 0)


@pytest.mark.parametrize(("dead", "counts"), [(1, (False, True)), (2, (True, False)), (3, (False, False))])
def test_a_dead_encoder_counts_nothing_and_goes_on_where_it_was(dead, counts):
    rover = srv1((1.5, 4.0, 0.0))
    drive(rover, 1.0, 0.3)
    before = rover.senses.encoders()
    rover.faults.set("dead_encoder", dead)
    drive(rover, 1.0, 0.3)
    after = rover.senses.encoders()
    assert tuple(b - a > 100 for a, b in zip(before, after, strict=True)) == counts
    rover.faults.clear()
    drive(rover, 0.2, 0.3)
    assert all(0 < b - a < 200 for a, b in zip(after, rover.senses.encoders(), strict=True))


# faults


def test_blind_infrared_reads_far():
    rover = srv1((0.4, 2.0, pi))
    assert rover.senses.infrared() < 0.4
    rover.faults.set("blind_infrared")
    assert rover.senses.infrared() == KNOWN["infrared"]["far"]


def test_ghosts_of_the_sonar_are_nearer_or_farther_and_as_many_as_told():
    rover = srv1((1.2, 4.0, 0.0))
    true = rover.senses.sonar()
    rover.faults.set("sonar_ghost", 0.3)
    seen = [rover.senses.sonar() for _ in range(500)]
    nearer, farther = [read for read in seen if read < true - 0.2], [read for read in seen if read > true + 0.2]
    assert 90 < len(nearer) + len(farther) < 190
    assert min(len(nearer), len(farther)) > 30
    assert min(nearer) >= KNOWN["sonar"]["near"]
    assert max(farther) <= KNOWN["sonar"]["far"]


# the analogue channels


def test_channels_are_counts_and_others_are_nothing(one):
    one.plant.put(1.2, 4.0, 0.0)
    for channel in range(-2, 40):
        count = one.senses.analogue(channel)
        assert type(count) is int
        assert 0 <= count <= 1023
        if channel not in tuple(Channel):
            assert count == 0
    assert 15 < temperature_c(one.senses.analogue(Channel.TEMPERATURE)) < 25
    assert 0.3 < share(one.senses.analogue(Channel.HUMIDITY)) < 0.6
    assert 0.1 < share(one.senses.analogue(Channel.LIGHT)) < 0.8


@given(pose=poses())
def test_the_infrared_channel_tells_what_the_sensor_reads(one, pose):
    one.plant.put(*pose)
    counts = one.senses.analogue(Channel.INFRARED)
    read = one.senses.infrared()
    assert infrared_m(counts, KNOWN["infrared"]) == pytest.approx(read, abs=0.1)


@given(st.floats(0, 1e7), st.integers(0, 1000), poses())
def test_air_and_light_are_plausible_and_slow(now, seed, pose):
    air = Climate(HALL, seed)
    x, y, _ = pose
    for read, low, high, slow in (
        (air.temperature, 17, 25, 0.02),
        (air.humidity, 0.3, 0.6, 0.002),
        (air.light, 0, 1, 0.01),
    ):
        assert low < read(now, x, y) < high
        assert abs(read(now + 1, x, y) - read(now, x, y)) < slow
        assert read(now, x, y) == read(now, x, y)
    assert 0 <= air.presence(now, x, y) <= 1


def test_it_is_warmer_and_drier_at_the_reptiles_lamp():
    air, (x, y) = Climate(HALL), next(case.at for case in HALL.cases if case.name == "Reptiles")
    assert air.temperature(0, x, y - 0.7) > air.temperature(0, 1, 1) + 0.5
    assert air.humidity(0, x, y - 0.7) < air.humidity(0, 1, 1)


def test_visitors_come_and_go():
    air = Climate(HALL, 4)
    seen = [is_present(round(1023 * air.presence(t, 6.0, 2.3))) for t in np.arange(0, 200 * VISIT_S, 5.0)]
    assert 0.03 < np.mean(seen) < 0.4
    assert sum(a != b for a, b in pairwise(seen)) > 10
