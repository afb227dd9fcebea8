"""Messages of ROS 1 and ROS 2 through rosbridge_server are read: null, Infinity, rounding, both kinds of stamps."""

import json
import math

import pytest

from robots.kit.description import load
from robots.kit.drivers.irat.messages import BatteryState, Odometry, Picture, Ranges, current_of, stamp_of
from robots.kit.drivers.irat.protocol import FULL, Status, Velocity
from robots.kit.drivers.rosbridge import Malformed, OutOfBounds, decode, encode, numeral, operation, received

FAR, BATTERY = load("irat")["range"]["far"], load("irat")["battery"]
HUGE = 10**400


def short(value):
    return str(value)[:12]


def scan(*values, **more):
    return Ranges.decode(decode(json.dumps({"ranges": values, "range_max": 0.8, **more})))


@pytest.mark.parametrize("nothing", [None, math.inf, math.nan, 0.80001, 5.0, 1e308, HUGE], ids=short)
def test_a_range_in_which_nothing_is_near_is_the_farthest(nothing):
    assert scan(0.1, nothing, 0.3) == Ranges(0.3, 0.8, 0.1)


def test_what_is_too_near_to_be_measured_is_near():
    """By REP 117 -Infinity is an object nearer than the sensor's least range."""
    assert scan(0.1, -math.inf, 0.3).ahead == 0.0


@pytest.mark.parametrize("farthest", [None, 0, -1, math.inf, math.nan, "far", 1e308, HUGE], ids=short)
def test_a_scan_without_a_usable_farthest_range_takes_that_of_the_description(farthest):
    assert scan(0.1, None, 0.3, range_max=farthest).ahead == FAR


@pytest.mark.parametrize("wrong", ["near", True, [], {}, -1, HUGE * -1], ids=short)
def test_what_is_no_range_is_refused(wrong):
    with pytest.raises(Malformed):
        scan(0.1, wrong, 0.3)


def pose(**orientation):
    return {
        "header": {"stamp": {"sec": 1700000000, "nanosec": 250000000}, "frame_id": "odom"},
        "pose": {"pose": {"position": {"x": 1.0, "y": 2.0, "z": 0.0}, "orientation": orientation}},
        "twist": {"twist": Velocity(0.1, 0.2).encode()},
    }  # fmt: skip


@pytest.mark.parametrize(
    ("z", "w", "heading"),
    [(0.0, 1.0000001, 0.0), (-1.0000001, 0.0, -math.pi), (1e-9, -1.0000001, 0.0), (0.70711, 0.70711, math.pi / 2)],
)
def test_an_orientation_that_was_rounded_is_read(z, w, heading):
    read = Odometry.decode(pose(x=0.0, y=0.0, z=z, w=w))
    assert math.cos(read.heading - heading) == pytest.approx(1.0)
    assert read.stamp == pytest.approx(1700000000.25)


@pytest.mark.parametrize(("z", "w"), [(0.0, 0.0), (0.0, 2.0), (0.3, 0.3), (None, 1.0), (HUGE, 0.0)], ids=short)
def test_what_is_no_orientation_is_refused(z, w):
    with pytest.raises(Malformed):
        Odometry.decode(pose(z=z, w=w))


def test_stamps_of_ros_1_and_of_ros_2_are_read():
    for stamp in ({"secs": 5, "nsecs": 500_000_000}, {"sec": 5, "nanosec": 500_000_000}):
        assert stamp_of({"header": {"stamp": stamp}}) == 5.5
    for stamp in ({"sec": HUGE}, {"secs": None, "nsecs": 1}, {"sec": 1, "nanosec": -1}):
        with pytest.raises(Malformed):
            stamp_of({"header": {"stamp": stamp}})


def battery(**values):
    full = {"voltage": 8.0, "current": -0.7, "charge": 1.2, "capacity": 1.9, "design_capacity": 1.9,
            "percentage": 0.9, "power_supply_status": FULL}  # fmt: skip
    return BatteryState.decode(decode(json.dumps(full | values)))


@pytest.mark.parametrize(("percentage", "share"), [(1.0000001, 1.0), (-1e-7, 0.0), (0.5, 0.5)])
def test_a_share_that_was_rounded_is_read(percentage, share):
    assert battery(percentage=percentage).share == share


@pytest.mark.parametrize("unmeasured", [None, math.nan])
def test_what_a_battery_does_not_measure_is_taken_from_what_it_does(unmeasured):
    assert battery(current=unmeasured).current == 0.0
    assert battery(percentage=unmeasured).share == pytest.approx(1.2 / 1.9)
    assert battery(percentage=unmeasured, capacity=unmeasured).share == pytest.approx(1.2 / 1.9)
    by_voltage = battery(percentage=unmeasured, charge=unmeasured)
    assert by_voltage.share == pytest.approx((8.0 - BATTERY["empty"]) / (BATTERY["full"] - BATTERY["empty"]))
    assert battery(percentage=unmeasured, charge=unmeasured, voltage=9.5).share == 1.0
    assert battery(percentage=unmeasured, charge=unmeasured, voltage=2.0).share == 0.0
    assert battery(percentage=unmeasured, charge=1.2, capacity=0.0, design_capacity=0.0).share == by_voltage.share


@pytest.mark.parametrize(
    "wrong", [{"voltage": None}, {"percentage": 87.0}, {"percentage": "x"}, {"current": HUGE}], ids=short
)
def test_what_is_no_battery_is_refused(wrong):
    with pytest.raises(Malformed):
        battery(**wrong)


def test_noise_below_zero_is_no_current():
    assert [current_of({"data": value}) for value in (-0.003, 0, 1.2)] == [0.0, 0.0, 1.2]
    for wrong in (None, -HUGE, 1e9):  # NaN: the charger's current is not known, so the newest known one grows old
        with pytest.raises(Malformed):
            current_of({"data": wrong})


def test_formats_that_ros_cameras_write_are_jpegs():
    for name in ("jpeg", "jpg", "rgb8; jpeg compressed bgr8", "JPEG"):
        found = Picture.decode({"format": name, "data": "/9g=", "header": {"stamp": {"sec": 3, "nanosec": 0}}})
        assert found == Picture(b"\xff\xd8", 3.0)


@pytest.mark.parametrize("value", [HUGE, -HUGE, 10**309], ids=short)
def test_an_integer_with_more_than_308_digits_is_out_of_bounds(value):
    with pytest.raises(OutOfBounds, match=r"^n is an integer of \d+ digits; it must be from 0 to 5 m$"):
        numeral({"n": value}, "n", 0, 5, "m")
    with pytest.raises(Malformed):
        Status.decode({"boot": value})


def test_numbers_that_json_lacks_are_read_and_nothing_else_that_is_no_json():
    assert decode('{"a": Infinity, "b": [-Infinity]}') == {"a": math.inf, "b": [-math.inf]}
    assert math.isnan(decode('{"a": NaN}')["a"])
    wrong = ('{"a": nan}', '{"a": NaN', '{"a": Infinity, "b": "\\ud800"}', "NaN", '{"a": NaN, "b": ' + "9" * 5000 + "}",
             '{"a": NaN, "b": ' + "[" * 9000, b'{"a": NaN, "b": "\xff"}', "")  # fmt: skip
    for text in wrong:
        with pytest.raises(Malformed):
            decode(text)
    with pytest.raises(Malformed, match="x must be a number"):
        Velocity.decode({"linear": decode('{"x": NaN}')})
    assert encode(op="publish", msg=decode('{"a": Infinity}')) == '{"op":"publish","msg":{"a":null}}'


def test_a_throttle_that_is_huge_is_refused_by_a_sentence():
    with pytest.raises(Malformed, match="throttle_rate is an integer of 401 digits"):
        operation(received('{"op": "subscribe", "topic": "/a", "throttle_rate": ' + str(HUGE) + "}"))
