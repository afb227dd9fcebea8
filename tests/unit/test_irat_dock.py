"""The iRat's dock and its markers: where contacts close, and from where the markers can be read."""

from math import pi

import cv2
import numpy as np
import pytest

from robots.kit.drivers.irat.markers import BITS, OUTER_IDS, SMALL_ID, turned
from simulators.common.mesh import placed
from simulators.irat.cameras import RobotCamera, Stage
from simulators.irat.dock import DOCKED_M
from simulators.irat.maze import DOCK, along_corridors
from simulators.irat.plant import docked
from tests.unit.rover_worlds import drive, irat, rest


@pytest.fixture(scope="module")
def stage():
    return Stage()


# the dock


def test_a_robot_at_the_stop_charges_and_comes_out_backwards():
    one = irat()
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
    one = irat((x + aside, y - ahead, heading + turn))
    assert all(one.plant.contacts) is mates


@pytest.mark.parametrize(
    ("aside", "turn", "docks"),
    [(0, 0, True), (0.02, 0.05, True), (-0.02, -0.05, True), (0, 0.5, False), (0.06, -0.1, False)],
)
def test_the_funnel_leads_in_who_comes_nearly_straight(aside, turn, docks):
    """Nobody steers here: at too acute an angle only one contact closes, as with some of the paper's."""
    one = irat((DOCK[0] + aside, 1.45, pi / 2 + turn))
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


def test_on_the_open_floor_the_marker_is_seen_from_the_papers_distance():
    """From 1.6 m, where it has 6.7 pixels, in some pictures of many; from 1.2 m in most; without walls in between."""
    eye = RobotCamera(Stage(with_maze=False), seed=5)
    seen = {}
    for away in (1.2, 1.6):
        poses = [placed(DOCK[0] + 0.003 * k, DOCK[1] - away - 0.07, 0, pi / 2 + 0.01 * (k % 5 - 2)) for k in range(20)]
        seen[away] = sum(bool(decoded(eye.take(pose)) & set(OUTER_IDS)) for pose in poses)
    assert seen[1.6] >= 2
    assert seen[1.2] >= 14
