"""The hall rover's hall and its body in it: geometry, a straight way, turns with slip, contacts, rest."""

from itertools import pairwise
from math import cos, dist, hypot, inf, pi, sin, tau

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robots.kit.description import load
from robots.kit.drivers.srv1.hall import hall, read
from simulators.common.rovers.body import TICK_S
from simulators.common.rovers.simulator import StoredState, keep
from simulators.srv1.flash import restore_user
from simulators.srv1.plant import Plant
from simulators.srv1.simulator import restore
from tests.unit.rover_worlds import drive, poses, rest, srv1

HALL = hall()
RADIUS = load("srv1")["body"]["wheel_radius"]
TRACK = load("srv1")["body"]["track"]
OPEN = (1.5, 4.0, 0.0)  # nothing is near


def between(a, b, at):
    return a[0] + (b[0] - a[0]) * at, a[1] + (b[1] - a[1]) * at


# the geometry


@given(poses(), st.floats(0, 1))
def test_a_ray_runs_through_free_room_until_it_meets_a_surface(pose, share):
    x, y, angle = pose
    away, what = HALL.ray(x, y, angle)
    assert 0 < away < hypot(HALL.width, HALL.depth)
    end = x + away * cos(angle), y + away * sin(angle)
    assert HALL.distance(*end) == pytest.approx(0, abs=1e-9)
    if what is not None:
        assert what.distance(*end) == pytest.approx(0, abs=1e-9)
    inner = away * 0.999 * share
    assert HALL.distance(x + inner * cos(angle), y + inner * sin(angle)) > 0


@given(poses(), st.floats(-pi, pi))
def test_nothing_is_nearer_than_the_distance_says(pose, angle):
    x, y, _ = pose
    assert HALL.ray(x, y, angle)[0] >= HALL.distance(x, y) - 1e-9


def test_rays_along_the_axes_are_no_exception():
    away = {angle: HALL.ray(1.5, 4.0, angle) for angle in (0.0, pi / 2, pi, -pi / 2)}
    assert [round(away[a][0], 9) for a in away] == [pytest.approx(6 - 0.55 - 1.5), 4.0, 1.5, 4.0]
    assert [what and what.name for _, what in away.values()] == ["Globe", None, None, None]
    assert HALL.cases[0].ray(0.5, 0.5, 0.0) == inf


def test_each_way_of_the_map_is_free_for_the_rover_and_leads_back():
    body = load("srv1")["body"]
    reach = hypot(body["length"], body["width"]) / 2
    nodes = {node.name: node for node in HALL.nodes}
    for node in HALL.nodes:
        for name in node.to:
            assert node.name in nodes[name].to, (node.name, name)
            nearest = min(HALL.distance(*between(node.at, nodes[name].at, at)) for at in np.linspace(0, 1, 101))
            assert nearest > reach + 0.1, (node.name, name, nearest)
    assert HALL.distance(*HALL.home[:2]) > reach


def test_one_case_is_black_and_names_are_names_of_one():
    assert [case.name for case in HALL.cases if case.black] == ["Meteorite"]
    assert len({thing.name for thing in HALL.things}) == len(HALL.things)


def test_a_description_that_lacks_something_is_refused():
    described = dict(load("srv1")["hall"])
    assert read(described) == HALL
    for name in ("width", "home", "case", "node"):
        with pytest.raises(KeyError):
            read({key: told for key, told in described.items() if key != name})
    with pytest.raises(ValueError, match="unpack"):
        read({**described, "tower": [1.0]})


# the body


def rolled(plant, seconds, left, right):
    """Drive with these rim speeds, from rest; return what the rear wheels rolled (m, m) and how far it turned (rad)."""
    begun, turned, last = plant.angles, 0.0, plant.pose[2]
    for tick in range(round(seconds / TICK_S)):
        share = min(1.0, tick / 20)
        plant.step(left * share, right * share)
        turned += (plant.pose[2] - last + pi) % tau - pi
        last = plant.pose[2]
    return *((b - a) * RADIUS for a, b in zip(begun, plant.angles, strict=True)), turned


@pytest.mark.parametrize("speed", [0.02, 0.1, 0.25, 0.4, -0.3])
def test_a_straight_way_is_what_the_wheels_say(speed):
    plant = Plant((6.5, 6.45, 0.3) if speed < 0 else (1.5, 4.0, 0.0))
    x, y, _ = plant.pose
    left, right, turned = rolled(plant, 5.0, speed, speed)
    assert left == pytest.approx(right, rel=1e-3)
    assert dist(plant.pose[:2], (x, y)) == pytest.approx(abs(left), rel=0.01)
    assert abs(turned) < 0.002


@pytest.mark.parametrize("speed", [0.03, 0.1, 0.2, 0.35])
@pytest.mark.parametrize("side", [1, -1])
def test_a_turn_in_place_is_10_to_35_per_cent_less_than_the_wheels_say(speed, side):
    plant = Plant(OPEN)
    left, right, turned = rolled(plant, 4.0, -side * speed, side * speed)
    share = turned / ((right - left) / TRACK)
    assert 0.65 <= share <= 0.90
    assert share == pytest.approx(0.76, abs=0.04), "as the note at the friction says"
    assert dist(plant.pose[:2], OPEN[:2]) < 0.01


def test_a_turn_on_the_way_slips_as_much():
    left, right, turned = rolled(Plant((4.5, 4.0, -1.0)), 4.0, 0.1, 0.25)
    assert 0.65 <= turned / ((right - left) / TRACK) <= 0.90


def test_at_rest_it_costs_nothing():
    plant = Plant(OPEN)
    rolled(plant, 1.0, 0.3, 0.1)
    for _ in range(100):
        plant.step(0.0, 0.0)
    at, pose = plant._data.time, plant.pose
    for _ in range(50):
        plant.step(0.0, 0.0)
    assert plant._data.time == at, "no step of the physics"
    assert plant.pose == pose
    rolled(plant, 1.0, 0.3, 0.3)
    assert plant._data.time > at
    assert plant.pose[0] != pose[0]


def test_it_does_not_drive_through_a_showcase_and_tells_what_it_touches():
    case = HALL.cases[0]
    plant = Plant((case.at[0] - case.half[0] - 0.5, case.at[1], 0.0))
    assert plant.contacts == ()
    rolled(plant, 4.0, 0.4, 0.4)
    assert plant.contacts == (case.name,)
    assert case.distance(*plant.pose[:2]) == pytest.approx(0.14, abs=0.01)
    assert plant.angles[0] * RADIUS > 1.0, "its wheels spin"


def test_walls_keep_it_in():
    plant = Plant((0.6, 6.0, pi))
    rolled(plant, 4.0, 0.4, 0.4)
    assert plant.contacts == ("wall2",)
    assert plant.pose[0] > 0.13


def test_a_showcase_that_was_moved_is_met_where_it_stands_now():
    plant = Plant((1.2, 2.6, 0.0))
    assert plant.ray((0.0, 0.0, 0.1), 0.0) == (pytest.approx(1.0), "Ammonites")
    plant.move("Ammonites", 0.4, 0.0)
    assert plant.ray((0.0, 0.0, 0.1), 0.0) == (pytest.approx(1.4), "Ammonites")
    assert plant.offset("Ammonites") == pytest.approx((0.4, 0.0))
    rolled(plant, 5.0, 0.4, 0.4)
    assert plant.contacts == ("Ammonites",)
    assert plant.pose[0] == pytest.approx(2.46, abs=0.02)
    with pytest.raises(KeyError):
        plant.move("Pterodactyl", 1.0, 0.0)


def test_on_a_slippery_floor_the_wheels_turn_and_the_rover_lags():
    plant = Plant(OPEN)
    plant.grip(1.0)
    left, *_ = rolled(plant, 2.0, 0.3, 0.3)
    assert left > 0.4
    assert plant.pose[0] - OPEN[0] < 0.5 * left
    plant.grip(0.0)
    x = plant.pose[0]
    left, *_ = rolled(plant, 2.0, 0.3, 0.3)
    assert plant.pose[0] - x == pytest.approx(left, rel=0.1)


def test_blocked_wheels_do_not_turn():
    plant = Plant(OPEN)
    plant.block(True)
    left, right, _ = rolled(plant, 1.0, 0.3, 0.3)
    assert (left, right) == pytest.approx((0, 0), abs=1e-3)
    assert plant.pose[0] == pytest.approx(OPEN[0], abs=1e-3)
    plant.block(False)
    assert rolled(plant, 1.0, 0.3, 0.3)[0] > 0.2


def test_a_rover_that_was_carried_stands_there_and_its_wheels_have_not_turned():
    plant = Plant(OPEN)
    rolled(plant, 1.0, 0.3, 0.3)
    angles = plant.angles
    plant.put(10.6, 4.0, 2.0)
    assert plant.pose == pytest.approx((10.6, 4.0, 2.0))
    assert (plant.angles == angles).all()


# the world


def test_it_comes_to_rest_and_says_so():
    one = srv1()
    drive(one, 2.0, 0.3, 0.4)
    rest(one)
    assert one.idle
    assert [n["event"] for n in one.noted] == ["motion", "rest"]
    assert one.driven == pytest.approx(0.54, abs=0.06)


def test_a_number_names_always_the_same_place_to_which_it_is_carried():
    seen = []
    for number in (5, 6, 5, -1):
        one = srv1(seed=number + 2)
        one.faults.set("carried", number)
        one.tick()
        seen.append(one.plant.pose)
    assert seen[0] == seen[2] != seen[1]
    assert seen[3] == pytest.approx(HALL.home)
    for before, after in pairwise(seen):
        assert HALL.distance(*before[:2]) > 0.25 or before == after


def test_a_showcase_is_moved_and_put_back():
    one = srv1()
    one.faults.set("moved_case", 1)
    one.tick()
    assert one.offsets == {"Ammonites": pytest.approx((0.6, 0.0))}
    one.faults.set("moved_case", 4)
    one.tick()
    assert one.offsets == {"Minerals": pytest.approx((-0.6, 0.0))}
    one.faults.clear()
    one.tick()
    assert one.offsets == {}


def test_a_showcase_is_not_put_on_the_rover():
    one = srv1((4.1, 2.6, 0.0))
    one.faults.set("moved_case", 1)
    one.tick()
    assert one.offsets == {}
    drive(one, 3.0, 0.3)
    assert one.offsets == {"Ammonites": pytest.approx((0.6, 0.0))}
    assert one.plant.contacts == ()


def test_cells_get_empty_and_are_changed():
    one = srv1(charge=0.021)
    volts = one.battery.voltage
    drive(one, 1.0, 0.2)
    assert one.battery.voltage < volts
    for _ in range(300):
        one.tick(0.1)
    assert not one.power
    at = one.plant.pose
    drive(one, 1.0, 0.2)
    assert one.plant.pose == at, "without power it does not drive"
    for _ in range(700):
        one.tick(0.1)
    assert one.power
    assert one.battery.charge > 0.99
    assert "cells_changed" in [n["event"] for n in one.noted]


@settings(max_examples=50)
@given(st.binary(max_size=200))
def test_a_state_that_cannot_be_read_is_that_of_a_new_rover(tmp_path_factory, data):
    path = tmp_path_factory.mktemp("state") / "state.json"
    path.write_bytes(data)
    assert restore(path).pose == HALL.home


@pytest.mark.parametrize("pose", ["[NaN, 1, 0]", "[1, 1e308, 0]", "[-1, 1, 0]", "[1, 1, Infinity]", "[1, 1]", "7"])
def test_a_pose_outside_of_the_hall_is_not_believed(tmp_path, pose):
    path = tmp_path / "state.json"
    path.write_text(f'{{"pose": {pose}, "charge": 0.5, "boot": 3}}')
    assert restore(path).pose == HALL.home


def test_pose_charge_and_boot_number_are_kept(tmp_path):
    path = tmp_path / "state.json"
    kept = StoredState((4.5, 4.0, -1.0), 0.7, 12)
    keep(path, kept)
    assert restore(path) == kept
    assert restore_user(tmp_path / "none") == b""
