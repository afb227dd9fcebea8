"""The iRat's world: maze, dock, battery, wheels and dead reckoning, in time of their own."""

import json
import time
from itertools import pairwise
from math import cos, dist, hypot, pi, sin

import cv2
import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robots.description import load
from robots.drivers.irat.markers import BITS, OUTER_IDS, SMALL_ID, turned
from simulators.common.faults import FaultBoard
from simulators.common.mesh import placed
from simulators.irat import maze, scene, scenery
from simulators.irat.battery import Battery
from simulators.irat.cameras import RobotCamera, Stage
from simulators.irat.dock import DOCKED_M
from simulators.irat.drive import Drive, End
from simulators.irat.maze import COLUMN, DOCK, HALF_M, STROKES, WALL_M, along_corridors, off_centre, walls
from simulators.irat.plant import TICK_S, docked
from simulators.irat.state import Kept, keep, restore
from simulators.irat.world import World

MOTION = load("irat")["motion"]
OPEN = (1.0, 0.8, 0.0)  # a place on the open floor


def world(pose=None, seed=3, with_maze=True, faults=None):
    noted = []
    made = World(
        lambda event, **more: noted.append({"event": event, **more}), faults or FaultBoard(), seed, pose, 1.0, with_maze
    )
    made.noted = noted
    return made


def drive(one, seconds, linear, angular=0.0):
    for _ in range(round(seconds / TICK_S)):
        one.drive.velocity(linear, angular, 1, one.now)
        one.tick()


def rest(one):
    one.drive.hold()
    for _ in range(100):
        one.tick()


@pytest.fixture(scope="module")
def stage():
    return Stage()


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


def test_corridors_are_free_and_connected(stage):
    one = world()
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
    one = world()
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


# the dock


def test_a_robot_at_the_stop_charges_and_comes_out_backwards():
    one = world()
    rest(one)
    assert one.charging
    drive(one, 2.0, -0.1)
    rest(one)
    assert not one.charging
    drive(one, 4.0, 0.1)
    rest(one)
    assert one.charging
    assert [n["event"] for n in one.noted if "charging" in n["event"]] == ["charging", "not_charging", "charging"]


@pytest.mark.parametrize(("aside", "ahead", "turn", "mates"), [
    (0, 0, 0, True), (0.004, 0, 0, True), (0, 0.005, 0.05, True), (0.012, 0, 0, False), (0, 0, 0.35, False),
    (0, 0.02, 0, False), (0, 0, pi, False),
])  # fmt: skip
def test_contacts_close_only_where_the_robot_is_square_enough(aside, ahead, turn, mates):
    x, y, heading = docked()
    one = world((x + aside, y - ahead, heading + turn))
    assert all(one.plant.contacts) is mates


@pytest.mark.parametrize(
    ("aside", "turn", "docks"),
    [(0, 0, True), (0.02, 0.05, True), (-0.02, -0.05, True), (0, 0.5, False), (0.06, -0.1, False)],
)
def test_the_funnel_leads_in_who_comes_nearly_straight(aside, turn, docks):
    """Nobody steers here: at too acute an angle only one contact closes, as with some of the paper's."""
    one = world((DOCK[0] + aside, 1.45, pi / 2 + turn))
    drive(one, 6.0, 0.08)
    assert one.charging is docks


# the markers


def distance(a, b):
    return sum(p != q for x, y in zip(a, b, strict=True) for p, q in zip(x, y, strict=True))


def turns(bits):
    found = [bits]
    for _ in range(3):
        found.append(turned(found[-1]))
    return found


def test_codes_differ_from_each_other_and_from_themselves_turned():
    for number, bits in enumerate(BITS):
        assert min(distance(bits, other) for other in turns(bits)[1:]) >= 4
        for other in range(number):
            least = min(distance(bits, one) for one in turns(BITS[other]))
            assert least == 1 if {number, other} == set(OUTER_IDS) else least >= 4


def decoded(picture):
    """Return the markers' numbers in a picture, enlarged three times, by OpenCV's own detector."""
    codes = [cv2.aruco.Dictionary.getByteListFromBits(np.array(bits, np.uint8)) for bits in BITS]
    detector = cv2.aruco.ArucoDetector(cv2.aruco.Dictionary(np.concatenate(codes), 3, 0))
    large = cv2.resize(cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY), None, fx=3, fy=3, interpolation=cv2.INTER_CUBIC)
    numbers = detector.detectMarkers(large)[1]
    return set() if numbers is None else {int(n) for n in numbers.ravel()}


@pytest.mark.parametrize(
    ("away", "wanted"),
    [(1.4, "outer"), (1.0, "outer"), (0.6, "outer"), (0.25, "outer"), (0.1, "small"), (0.0, "small")],
)
def test_markers_can_be_read_in_the_robots_pictures(stage, away, wanted):
    """From the pose in which it charges to 1.4 m before it, where the outer marker has 7.6 pixels."""
    eye = RobotCamera(stage, seed=4)
    found = [
        decoded(eye.take(placed(DOCK[0] + 0.002 * (k % 5), DOCK[1] - DOCKED_M - away - 0.003 * k, 0, pi / 2)))
        for k in range(10)
    ]
    ids = set(OUTER_IDS) if wanted == "outer" else {SMALL_ID}
    assert sum(bool(f & ids) for f in found) >= 8


def test_most_places_show_no_marker(stage):
    eye = RobotCamera(stage)
    false = sum(bool(decoded(eye.take(placed(x, y, 0, heading)))) for x, y, heading in along_corridors(0.3) if x > 0.5)
    assert false <= 2


# the battery


def test_the_battery_makes_about_seven_recharges_a_day():
    """Roaming at half speed until it is low, then charging until it is full: the paper's 7 a day, 47 % roaming."""
    battery, recharges, roamed, docked_now = Battery(1.0), 0, 0, False
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
    battery = Battery(charge)
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
    board = Drive(lambda event, **more: noted.append(event))
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
    board = Drive(lambda event, **more: None)
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
    one = world((0.2, 0.9, 0.0))
    drive(one, 4.0, 0.1)
    assert one.drive.stalled
    assert any(n["event"] == "stalled" for n in one.noted)
    assert off_centre(*one.plant.pose[:2]) < HALF_M, "and it stays in its corridor"


# dead reckoning


def test_the_same_seed_is_the_same_day():
    ways = []
    for seed in (3, 3, 4):
        one = world(OPEN, seed, with_maze=False)
        drive(one, 3.0, 0.1, 0.4)
        ways.append((one.odometry.x, one.odometry.y, one.odometry.heading, *one.plant.ranges()))
    assert ways[0] == ways[1] != ways[2]


def test_dead_reckoning_drifts_as_wheels_do():
    """A few per cent of the way, and some degrees a turn: too much to map with, little enough to start with."""
    errors, turns_off = [], []
    for seed in range(6):
        one = world(OPEN, seed, with_maze=False)
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


def test_a_day_runs_far_faster_than_real_time():
    """The world alone: 24 times real time is wanted of world, camera and map together."""
    one = world((0.2, 1.2, -pi / 2))
    drive(one, 0.2, 0.1)
    began = time.process_time()
    drive(one, 10.0, 0.05, 0.3)
    assert time.process_time() - began < 10.0 / 24


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
    kept = restore(path)
    assert kept.pose == docked()
    assert kept.boot > 10**9


def test_a_state_is_kept(tmp_path):
    kept = Kept((1.0, 0.5, 2.0), 0.4, 7)
    keep(tmp_path / "state.json", kept)
    assert restore(tmp_path / "state.json") == kept
    assert restore(tmp_path / "none.json") == Kept(docked(), 1.0, 0)
    assert json.loads((tmp_path / "state.json").read_text())["boot"] == 7


def test_the_scene_compiles_with_and_without_a_maze():
    assert scene.spec().compile().ngeom > 100 > scene.spec(with_maze=False).compile().ngeom
    assert maze.WIDTH_M > maze.HEIGHT_M
