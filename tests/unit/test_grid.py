"""Grid scanning: the belief, where a scan puts the rover, how sure it says it is, and what it does when it is not."""

from dataclasses import replace
from math import atan2, hypot, inf, nan, pi, tau

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robots.kit.drivers.srv1.grid_map import range_map, sensors
from robots.kit.rovers.grid import (
    SCANS,
    TURNS,
    Beacon,
    Belief,
    Estimate,
    Plan,
    RangeMap,
    Scan,
    beacon_of,
    by_beacon,
    locate,
    next_step,
    scan_of,
    with_beacon,
)
from robots.kit.rovers.gridmap.beacon import HEARD
from robots.kit.rovers.gridmap.scan import headings_of
from simulators.common.faults import FaultBoard
from simulators.srv1.plant import Plant
from simulators.srv1.senses import Senses
from tests.unit.grid_world import KNOWN, NONE, TURN, World, off

WORLD, MAP = World(), range_map()
SEEDS = st.integers(0, 2**32 - 1)


def dice(seed):
    return np.random.default_rng(seed)


def found_by(pose_or_scan, belief=None):
    return locate(belief or Belief.uniform(MAP), pose_or_scan).estimate


@settings(max_examples=60)
@given(SEEDS)
def test_the_map_reads_what_the_hall_reads(seed):
    """Another geometry with rays says the same, but for what is thinner than the space between two of its rays."""
    pose = WORLD.place(dice(seed))
    x, y, heading = (np.array([value]) for value in pose)
    assert MAP.plan.nearest(x, y, heading, MAP.sonar_sensor)[0] <= WORLD.sonar(pose) + 1e-6
    finer = WORLD.read(pose, "sonar", MAP.sonar_sensor.half_cone, 400)
    assert MAP.plan.nearest(x, y, heading, MAP.sonar_sensor)[0] == pytest.approx(finer, abs=0.03)
    assert MAP.plan.room(x, y)[0] == pytest.approx(WORLD.hall.distance(*pose[:2]), abs=1e-9)


def test_infrared_light_does_not_come_back_from_black_glass_and_sees_nothing_behind():
    x, y, up = np.array([6.0]), np.array([6.5]), np.array([pi / 2])
    assert MAP.plan.nearest(x, y, up, MAP.infrared_sensor, light=True)[0] == MAP.infrared_sensor.far
    assert MAP.plan.nearest(x, y, up, MAP.infrared_sensor)[0] == pytest.approx(0.6 - 0.13)


def test_no_cell_inside_a_showcase_is_free():
    inside = [(3.0, 2.6), (9.0, 5.4), (6.0, 4.0), (-1.0, 1.0)]
    x, y = np.array(inside).T
    assert MAP.plan.room(x, y).tolist() == [0.0] * 4
    assert not MAP.free[int(2.6 / MAP.cell), int(3.0 / MAP.cell)]


@pytest.mark.parametrize("cell", [0.3, 0.7])
def test_wherever_the_rover_fits_there_is_a_cell(cell):
    """Also beside a showcase that covers the middle of the cell."""
    ranges, draw = range_map(cell), dice(8)
    poses = np.array([WORLD.place(draw, 0.16) for _ in range(2000)])
    held = Belief.uniform(ranges).at(poses) > 0.0
    assert held.mean() > (0.999 if cell < 0.5 else 0.98)
    assert ranges.plan.room(*np.moveaxis(ranges.place[ranges.free], -1, 0)).min() > 0.1


@settings(max_examples=30)
@given(st.floats(-3, 15), st.floats(-3, 15), st.floats(-7, 7), st.floats(0.01, 1))
def test_the_belief_sums_to_one_whatever_happens(x, y, heading, spread):
    """Also around a place out of the hall: then nothing is known, and no number is spoilt."""
    belief = Belief.around(MAP, (x, y, heading), spread, 0.1, lost=0.0)
    for after in (belief, belief.after_scan(Scan(np.zeros(1), np.array([1.0]), np.array([0.8])))):
        assert after.mass.sum() == pytest.approx(1.0)
        assert (after.mass >= 0.0).all()
        assert not after.mass[:, ~MAP.free].any()


@settings(max_examples=40)
@given(SEEDS)
def test_a_scan_without_noise_tells_the_truth(seed):
    draw = dice(seed)
    pose = WORLD.place(draw)
    scan, end = WORLD.scan(pose, draw, NONE)
    near = found_by(scan, Belief.around(MAP, (pose[0] + 0.2, pose[1] - 0.2, 0.0), 0.4))
    far, turn = off(near.pose, end)
    assert far < 0.06  # where little is within reach even exact readings tell no more; mostly it is within 0.01
    assert far < near.spread
    assert turn < 0.06
    assert near.is_known


def cases(count, seed, **world):
    """Yield (estimate with nothing known before, true pose) of rovers with noise."""
    draw = dice(seed)
    for _ in range(count):
        scan, end = World(**world).scan(WORLD.place(draw), draw)
        yield found_by(scan), end


def test_a_rover_of_which_nothing_is_known_is_found_and_the_spread_is_as_wide_as_it_is_wrong():
    """The circle that is said to hold the rover with 95 % does, and is not three times as wide as that needs."""
    judged = [(here, *off(here.pose, end)) for here, end in cases(120, 11)]
    known = [case for case in judged if case[0].is_known]
    assert len(known) >= 114
    assert sum(far > 0.15 for _, far, _ in known) <= 1
    assert np.median([far for _, far, _ in known]) < 0.03
    for name, at in (("spread", 1), ("heading_spread", 2)):
        held = [getattr(case[0], name) >= case[at] for case in judged]
        assert 0.90 <= np.mean(held) <= 0.995, name
        assert np.mean([getattr(case[0], name) / 3 >= case[at] for case in judged]) < 0.7, name


def test_visitors_whom_the_map_does_not_have_do_not_mislead_it():
    judged = [
        (here, off(here.pose, end)[0]) for here, end in cases(30, 5, visitors=((4.6, 6.4), (7.6, 2.0), (1.5, 4.5)))
    ]
    assert sum(here.is_known and far > 0.15 for here, far in judged) == 0
    assert sum(here.is_known for here, _ in judged) >= 25


def test_a_carried_rover_is_found_although_it_believes_to_be_elsewhere():
    draw = dice(3)
    for _ in range(10):
        scan, end = WORLD.scan(WORLD.place(draw), draw)
        belief = Belief.around(MAP, WORLD.place(draw), 0.3, 0.2)
        for number in range(SCANS):
            there = locate(belief, scan)
            if there.estimate.is_known:
                break
            belief, (scan, end) = there.belief, WORLD.scan(end, draw)
            assert next_step(there.estimate, number + 1) == ("scan" if number < SCANS - 1 else "ask")
        assert there.estimate.is_known
        assert off(there.estimate.pose, end)[0] < 0.15


def empty(width, depth):
    return RangeMap.of(Plan.of(width, depth), *sensors())


@pytest.mark.parametrize(("width", "depth", "ways"), [(5.0, 3.6, 2), (4.0, 4.0, 4)])
def test_in_an_empty_room_the_place_is_unknown_without_a_compass_and_known_with_one(width, depth, ways):
    """Turned by half a turn, or in a square by a quarter, the room looks the same."""
    ranges = empty(width, depth)
    heading = 0.4 + np.arange(18) * TURN * 0.8
    x, y = np.full(18, 1.3), np.full(18, 0.9)
    sonar = ranges.plan.nearest(x, y, heading, ranges.sonar_sensor)
    scan = Scan(heading - heading[-1], sonar, np.full(18, 0.8))
    lost = locate(Belief.uniform(ranges), scan).estimate
    assert not lost.is_known
    assert lost.share == pytest.approx(1 / ways, abs=0.1)
    assert lost.spread > 1.0
    assert next_step(lost, 1) == "scan"
    assert next_step(lost, SCANS) == "ask"
    told_by_compass = Scan(scan.turned, scan.sonar, scan.infrared, float(heading[-1]), 0.06)
    known = locate(Belief.uniform(ranges), told_by_compass).estimate
    assert known.is_known
    assert off(known.pose, (1.3, 0.9, heading[-1]))[0] < 0.03


def test_readings_that_are_not_of_this_hall_make_no_known_place():
    draw = dice(4)
    for _ in range(10):
        there = found_by(Scan(np.arange(18) * TURN, draw.uniform(0.2, 9.0, 18), np.full(18, 0.8), 0.0))
        assert not there.is_known


@given(SEEDS)
def test_the_beacon_tells_the_place_whatever_stands_in_the_hall(seed):
    draw = dice(seed)
    x, y, heading = WORLD.place(draw)
    east, north = x - WORLD.hall.tower[0], y - WORLD.hall.tower[1]
    beacon = Beacon(WORLD.hall.tower, hypot(east, north), atan2(north, east))
    alone = by_beacon(beacon, heading, 0.05)
    assert off(alone.pose, (x, y, heading))[0] < 1e-9
    assert 0.09 < alone.spread < 0.4
    cells = with_beacon(Belief.uniform(MAP), beacon)
    assert cells.mass.sum() == pytest.approx(1.0)
    (there, *_), (share, *_) = cells.peaks(1)
    assert hypot(there[0] - x, there[1] - y) < 0.75 * MAP.cell + 0.1
    assert share < 2 / MAP.bins, "it does not tell where the rover looks"


def test_with_the_beacon_an_ambiguous_scan_is_none():
    ranges = empty(5.0, 3.6)
    heading = 0.4 + np.arange(18) * TURN * 0.8
    sonar = ranges.plan.nearest(np.full(18, 1.3), np.full(18, 0.9), heading, ranges.sonar_sensor)
    scan = Scan(heading - heading[-1], sonar, np.full(18, 0.8))
    beacon = Beacon((2.5, 1.8), hypot(-1.2, -0.9), atan2(-0.9, -1.2))
    there = locate(Belief.uniform(ranges), scan, beacon).estimate
    assert there.is_known
    assert off(there.pose, (1.3, 0.9, heading[-1]))[0] < 0.03


def beacon_readings(draw, pose, count=TURNS):
    """Return what the tower tells of a rover that stands there, with noise and reflections."""
    east, north = pose[0] - WORLD.hall.tower[0], pose[1] - WORLD.hall.tower[1]
    away, bearing = hypot(east, north), atan2(north, east) + 0.01 * draw.normal()
    detours = np.where(draw.random(count) < 0.02, draw.uniform(0.3, 2.0, count), 0.0)
    ranges, bearings = away + 0.05 * draw.normal(size=count) + detours, bearing + 0.02 * draw.normal(size=count)
    return list(zip(ranges, bearings, strict=True))


@given(SEEDS)
def test_readings_of_the_beacon_tell_the_place_within_their_spread(seed):
    draw = dice(seed)
    pose = WORLD.place(draw)
    beacon = beacon_of(WORLD.hall.tower, beacon_readings(draw, pose))
    assert np.abs(beacon.differences(pose[0], pose[1])).max() < 4.0
    assert beacon.range_spread < 0.05, "together they tell more than one"


def test_a_beacon_that_is_heard_too_seldom_is_none():
    assert beacon_of((6.0, 4.0), [(1.0, 0.1)] * (HEARD - 1)) is None
    assert beacon_of((6.0, 4.0), [(1.0, pi - 0.01), (1.0, 0.01 - pi)] * HEARD).bearing == pytest.approx(pi, abs=0.02)


@pytest.mark.parametrize("bad", [nan, inf, 1e308])
def test_numbers_that_no_tower_tells_are_refused(bad):
    for reading in ((bad, 0.0), (1.0, bad)):
        with pytest.raises(ValueError):
            beacon_of((6.0, 4.0), [reading] * HEARD)


def changed(draw):
    """Return the hall with four showcases moved by half a metre the same way, which the map does not know."""
    cases, way = list(WORLD.hall.cases), float(draw.choice([-0.5, 0.5]))
    for number in draw.permutation(len(cases))[:4]:
        x, y = cases[number].at
        cases[number] = replace(cases[number], at=(x + way, y))
    return World(replace(WORLD.hall, cases=tuple(cases)))


def test_in_a_hall_that_has_changed_the_beacon_places_the_rover_where_the_map_lies():
    known, false, lies = 0, 0, 0
    for seed in range(30):
        draw = dice(seed)
        there = changed(draw)
        scan, pose = there.scan(there.place(draw), draw)
        beacon = beacon_of(WORLD.hall.tower, beacon_readings(draw, pose))
        with_it = locate(Belief.uniform(MAP), scan, beacon).estimate
        without = locate(Belief.uniform(MAP), scan).estimate
        known += with_it.is_known
        false += with_it.is_known and off(with_it.pose, pose)[0] > max(0.15, 1.5 * with_it.spread)
        lies += not without.is_known or off(without.pose, pose)[0] > 0.3
    assert lies >= 6, "sonar and map alone do not tell, or tell another place"
    assert known == 30
    assert false <= 1


def test_a_beacon_that_has_the_rover_outside_the_hall_tells_nothing():
    draw = dice(3)
    scan, _ = WORLD.scan(WORLD.place(draw), draw)
    wild = beacon_of(WORLD.hall.tower, [(90.0, 0.3)] * TURNS)
    assert locate(Belief.uniform(MAP), scan, wild).estimate == locate(Belief.uniform(MAP), scan).estimate


@given(SEEDS, st.floats(0.10, 0.35))
def test_encoders_and_compass_together_tell_the_turns_better_than_one_of_them(seed, slip):
    draw = dice(seed)
    truly = np.cumsum(np.concatenate([[draw.uniform(-pi, pi)], (1 - slip) * TURN + draw.normal(0, 0.01, 17)]))
    compass = np.remainder(truly + draw.normal(0, 0.05, 18), tau)
    headings = headings_of(np.full(17, TURN), compass)
    wrong = np.remainder(headings - truly + pi, tau) - pi
    assert np.abs(wrong).max() < 0.12
    assert wrong.std() < 0.05


@pytest.mark.parametrize("bad", [nan, inf, -inf, 1e308, -1.0])
def test_numbers_that_no_sensor_sends_are_refused(bad):
    good = np.ones(3)
    spoilt = np.array([1.0, bad, 1.0])
    with pytest.raises(ValueError):
        Scan(good, spoilt, good)
    with pytest.raises(ValueError):
        Scan(good, good, spoilt)
    with pytest.raises(ValueError):
        Beacon((6.0, 4.0), bad, 0.0)
    if abs(bad) > 1:
        with pytest.raises(ValueError):
            Scan(good, good, good, heading=bad)
        with pytest.raises(ValueError):
            scan_of([bad, 0.1], [0.0, 0.1, 0.2], good, good)
        with pytest.raises(ValueError):
            Belief.around(MAP, (1.0, bad, 0.0), 0.3)
    for readings in (0, 361):
        with pytest.raises(ValueError):
            Scan(np.ones(readings), np.ones(readings), np.ones(readings))
    with pytest.raises(ValueError):
        RangeMap.of(MAP.plan, MAP.sonar_sensor, MAP.infrared_sensor, cell=bad)


def test_a_pose_is_known_only_if_it_is_alone_near_and_agrees_with_the_map():
    sure = Estimate((1.0, 1.0, 0.0), 0.05, 0.05, 0.99, 0.9)
    assert sure.is_known
    assert next_step(sure, 1) == "go"
    for spread, share, agree in ((0.5, 0.99, 0.9), (0.05, 0.9, 0.9), (0.05, 0.99, 0.3)):
        assert not Estimate((1.0, 1.0, 0.0), spread, 0.05, share, agree).is_known


def test_the_simulated_rover_finds_itself_by_what_its_own_sensors_say():
    """MuJoCo's wheels slip, and its encoders, compass, sonar and infrared are all that is asked."""
    draw, body = dice(6), KNOWN["body"]
    for seed in range(8):
        plant = Plant(WORLD.place(draw))
        senses, counts, read = Senses(plant, WORLD.hall, FaultBoard(1), seed), [], []
        for number in range(TURNS):
            goal = plant.angles[1] + TURN * body["track"] / 2 / body["wheel_radius"]
            while number and plant.angles[1] < goal:
                plant.step(-0.15, 0.15)
            for _ in range(40):
                plant.step(0.0, 0.0)
            senses.advance(0.0)
            counts.append(senses.encoders())
            read.append((pi / 2 - np.radians(senses.compass()), senses.sonar(), senses.infrared()))
        rolled = np.diff(np.array(counts), axis=0) * tau * body["wheel_radius"] / body["ticks"]
        compass, sonar, infrared = np.array(read).T
        scan = scan_of((rolled[:, 1] - rolled[:, 0]) / body["track"], compass, sonar, infrared)
        there = found_by(scan, Belief.around(MAP, plant.pose, 0.5))
        far, turn = off(there.pose, plant.pose)
        assert there.is_known
        assert far < 0.06
        assert turn < 0.08
