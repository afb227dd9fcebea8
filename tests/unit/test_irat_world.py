"""The iRat's world: maze, dock, battery, wheels and dead reckoning, in time of their own."""

import json
from itertools import pairwise
from math import cos, dist, hypot, pi, sin

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robots.kit.description import load
from simulators.common.rovers.battery import Battery
from simulators.common.rovers.body import TICK_S
from simulators.common.rovers.motor_board import End
from simulators.common.rovers.simulator import StoredState, keep, restore
from simulators.irat import maze, scene, scenery
from simulators.irat.maze import COLUMN, DOCK, HALF_M, STROKES, WALL_M, along_corridors, off_centre, walls
from simulators.irat.plant import Plant, docked
from simulators.irat.world import motor_board
from tests.unit.rover_worlds import drive, irat, rest

MOTION = load("irat")["motion"]
OPEN = (1.0, 0.8, 0.0)  # a place on the open floor


# the maze


def test_the_maze_is_as_large_as_the_papers():
    corners = np.array([wall.back_begin for row in walls() for wall in row])
    assert 0 <= corners.min() <= 0.1
    assert 1.9 < corners[:, 0].max() <= 2.101
    assert 1.75 < corners[:, 1].max() <= 1.9


def test_walls_are_closed_rows_beside_the_corridors():
    for row in walls():
        assert all(a.end == b.begin for a, b in pairwise([*row, row[0]]))
        for wall in row:
            assert off_centre(*wall.begin) == pytest.approx(HALF_M, abs=0.012)
            assert dist(wall.begin, wall.back_begin) >= WALL_M - 1e-6
            middle = np.add(wall.begin, wall.end) / 2
            left = np.array([wall.begin[1] - wall.end[1], wall.end[0] - wall.begin[0]]) / wall.length
            assert off_centre(*(middle + 0.02 * left)) < off_centre(*(middle - 0.02 * left)), (
                "its free side is on its left"
            )


def test_the_letters_make_several_loops():
    """As many loops as there are things to drive around: two islands of walls, and the column."""
    assert len(walls()) == 3
    x, y, half = COLUMN
    nearest = min(np.hypot(*(np.array(w.begin) - (x, y))) for row in walls() for w in row)
    assert nearest - half * 1.42 > load("irat")["body"]["width"] + 0.05, "the robot passes on all sides"


def test_corridors_are_free_and_connected():
    one = irat()
    for x, y, heading in along_corridors(0.15):
        if dist((x, y), COLUMN[:2]) < 0.14:
            continue
        one.plant.put(x, y, heading)
        touching = {
            (c.geom1, c.geom2)
            for c in one.plant._data.contact
            if one.plant._model.geom("board").id not in (c.geom1, c.geom2)
        }
        in_dock = dist((x, y), docked()[:2]) < 0.15
        assert in_dock or not touching, (x, y)
    u, q, tail = STROKES
    assert min(maze._to_stroke(place, u) for place in q) < HALF_M
    assert maze._to_stroke(tail[0], u) < HALF_M


def test_things_stand_beside_the_corridors():
    for kind, x, y, _, _ in scenery.THINGS:
        assert off_centre(x, y) > HALF_M + 0.03, kind


def test_the_dock_is_seen_from_one_arm_of_the_u_only():
    one = irat()
    x, y, heading = DOCK
    marker = np.array([x + 0.01 * cos(heading), y + 0.01 * sin(heading), 0.06])
    seen = []
    for place in along_corridors(0.1):
        ray = np.array([*place[:2], 0.06]) - marker
        away = mujoco.mj_ray(
            one.plant._model, one.plant._data, marker, ray, one.plant._groups, 1, -1, np.zeros(1, np.int32)
        )
        if away < 0 or away > 1.0:
            seen.append(place)
    assert len(seen) > 10
    assert max(p[0] for p in seen) < 0.4
    assert max(dist(p[:2], marker[:2]) for p in seen) > 1.2


# the battery


def test_the_battery_makes_about_seven_recharges_a_day():
    """Roaming at half speed until it is low, then charging until it is full: the paper's 7 a day, 47 % roaming."""
    battery, recharges, roamed, docked_now = Battery(load("irat")["battery"]), 0, 0, False
    for _ in range(24 * 360):
        battery.advance(10.0, 0.0 if docked_now else 0.5, docked_now)
        roamed += not docked_now
        if docked_now and battery.full:
            docked_now, recharges = False, recharges + 1
        elif not docked_now and battery.charge < battery.figures["low"]:
            docked_now = True
    assert 6 <= recharges <= 8
    assert 0.40 < roamed / (24 * 360) < 0.55


@given(st.lists(st.tuples(st.floats(0, 3600), st.floats(-2, 2), st.booleans()), max_size=40), st.floats(0, 1))
def test_a_battery_is_never_more_than_full_or_less_than_empty(steps, charge):
    battery = Battery(load("irat")["battery"], charge)
    for seconds, speed, contacts in steps:
        before = battery.charge
        battery.advance(seconds, speed, contacts)
        assert 0 <= battery.charge <= 1
        assert (battery.charger_current > 0) is contacts or battery.charger_current == 0
        assert contacts or battery.charge <= before
        assert 5.5 < battery.voltage < 8.7


# wheels


actions = st.one_of(
    st.tuples(
        st.just("velocity"), st.floats(-MOTION["speed"], MOTION["speed"]), st.floats(-MOTION["turn"], MOTION["turn"])
    ),
    st.tuples(st.just("hold"), st.just(0.0), st.just(0.0)),
    st.tuples(st.just("wait"), st.floats(0, 1), st.just(0.0)),
)


@settings(max_examples=60, deadline=None)
@given(st.lists(actions, max_size=30))
def test_the_motor_board_keeps_its_limits_and_always_comes_to_rest(steps):
    noted = []
    board = motor_board(lambda event, **more: noted.append(event))
    now, most = 0.0, MOTION["speed"] + MOTION["turn"] * load("irat")["body"]["track"] / 2

    def ticks(count):
        nonlocal now
        for _ in range(count):
            before, now = board.target, now + TICK_S
            board.step(now, TICK_S, board.target, board.target == (0.0, 0.0))
            assert max(map(abs, board.target)) <= most + 1e-9
            assert (
                max(abs(a - b) for a, b in zip(board.target, before, strict=True)) <= MOTION["braking"] * TICK_S + 1e-9
            )

    for what, a, b in steps:
        if what == "velocity" and not board.holding:
            board.velocity(a, b, 1, now)
        elif what == "hold":
            board.hold()
        ticks(1 + int(a / TICK_S) if what == "wait" else 1)
    ticks(60)
    assert not board.moving
    assert board.target == (0.0, 0.0)
    assert [e for e in noted if e != "stalled"] == ["motion", "rest"] * board.motion


def test_a_hold_ends_with_rest_only():
    board = motor_board(lambda event, **more: None)
    board.velocity(0.2, 0, 1, 0.0)
    for k in range(20):
        board.velocity(0.2, 0, 1, k * TICK_S)
        board.step(k * TICK_S, TICK_S, board.target, False)
    board.hold(End.LOST)
    board.step(1.0, TICK_S, (0.2, 0.2), False)
    assert board.holding
    for k in range(60):
        board.step(1.0 + k * TICK_S, TICK_S, (0.0, 0.0), True)
    assert (board.moving, board.end) == (False, End.LOST)


def test_a_wall_stalls_the_wheels():
    one = irat((0.2, 0.9, 0.0))
    drive(one, 4.0, 0.1)
    assert one.drive.stalled
    assert any(n["event"] == "stalled" for n in one.noted)
    assert off_centre(*one.plant.pose[:2]) < HALF_M, "and it stays in its corridor"


# dead reckoning


def test_the_same_seed_is_the_same_day():
    ways = []
    for seed in (3, 3, 4):
        one = irat(OPEN, seed, with_maze=False)
        drive(one, 3.0, 0.1, 0.4)
        ways.append((one.odometry.x, one.odometry.y, one.odometry.heading, *one.plant.ranges()))
    assert ways[0] == ways[1] != ways[2]


def test_dead_reckoning_drifts_as_wheels_do():
    """A few per cent of the way, and some degrees a turn: too much to map with, little enough to start with."""
    errors, turns_off = [], []
    for seed in range(6):
        one = irat(OPEN, seed, with_maze=False)
        for _ in range(2):
            drive(one, 3.0, 0.15)
            rest(one)
            drive(one, 2.5, 0.0, 1.2)
            rest(one)
        x, y, heading = one.plant.pose
        errors.append(hypot(one.odometry.x - (x - OPEN[0]), one.odometry.y - (y - OPEN[1])))
        turns_off.append(abs((one.odometry.heading - heading + pi) % (2 * pi) - pi))
    assert 0.002 < np.median(errors) < 0.15
    assert 0.01 < max(turns_off) < 0.6


@pytest.mark.timed
def test_a_day_runs_far_faster_than_real_time(stopwatch):
    """The world alone: 24 times real time is wanted of world, camera and map together."""
    one = irat((0.2, 1.2, -pi / 2))
    drive(one, 0.2, 0.1)

    def took():
        began = stopwatch.process_time()
        drive(one, 10.0, 0.05, 0.3)
        return stopwatch.process_time() - began

    assert min(took() for _ in range(3)) < 10.0 / 24  # what else runs makes it take longer, never less


# what is stored


@pytest.mark.parametrize(
    "text",
    [
        "",
        "{",
        "[]",
        "7",
        '{"pose": [1, 2]}',
        '{"pose": ["x", 1, 2], "charge": 1, "boot": 1}',
        '{"pose": [NaN, 1, 2], "charge": 1, "boot": 1}',
        '{"pose": [1, 1, 2], "charge": 1e999, "boot": 1}',
        "\x00",
    ],
)
def test_a_spoilt_state_starts_in_the_dock_with_a_number_of_its_own(tmp_path, text):
    path = tmp_path / "state.json"
    path.write_text(text)
    kept = restore(path, docked())
    assert kept.pose == docked()
    assert kept.boot > 10**9


def test_a_state_is_kept(tmp_path):
    kept = StoredState((1.0, 0.5, 2.0), 0.4, 7)
    keep(tmp_path / "state.json", kept)
    assert restore(tmp_path / "state.json", docked()) == kept
    assert restore(tmp_path / "none.json", docked()) == StoredState(docked(), 1.0, 0)
    assert json.loads((tmp_path / "state.json").read_text())["boot"] == 7


def test_the_scene_compiles_with_and_without_a_maze():
    assert scene.spec().compile().ngeom > 100 > scene.spec(with_maze=False).compile().ngeom
    assert maze.WIDTH_M > maze.HEIGHT_M


@pytest.mark.parametrize("wrong", [float("nan"), float("inf"), -0.21, 1e308])
def test_the_motor_board_takes_no_velocity_outside_its_bounds(wrong):
    board = motor_board(lambda event, **more: None)
    for linear, angular in ((wrong, 0.0), (0.0, wrong * 15)):
        with pytest.raises(ValueError, match="no velocity"):
            board.velocity(linear, angular, 1, 0.0)
    assert board.step(0.02, 0.02, (0.0, 0.0), True) == (0.0, 0.0)
    assert not board.moving


def test_wheels_that_are_blocked_at_full_speed_stop_the_robot_where_it_is():
    for place in along_corridors(0.3)[::28]:
        plant = Plant(tuple(map(float, place)))
        for blocked in (False, True, False):
            plant.block(blocked)
            for _ in range(40):
                before = plant.pose
                plant.step(0.19, 0.19)
                assert hypot(plant.pose[0] - before[0], plant.pose[1] - before[1]) < 0.03  # a tick at full speed: 0.004
