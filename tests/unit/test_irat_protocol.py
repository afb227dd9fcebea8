"""rosbridge frames and the iRat's messages: what one end writes the other reads, and nothing else passes."""

import json
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.kit.description import load
from robots.kit.drivers import rosbridge
from robots.kit.drivers.irat.messages import BatteryState, Odometry, Picture, Ranges, recharge_state
from robots.kit.drivers.irat.protocol import (  # fmt: skip
    CHARGING,
    DISCHARGING,
    FULL,
    LARGEST_EPOCH,
    SERVICES,
    TOPICS,
    Status,
    Velocity,
    epoch_of,
)
from robots.kit.drivers.rosbridge import Malformed, OutOfBounds, decode, encode, numeral, operation, received

MOTION = load("irat")["motion"]
anything = st.recursive(
    st.none() | st.booleans() | st.floats() | st.integers() | st.text(max_size=8),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=6), inner, max_size=3), max_leaves=12,
)  # fmt: skip
meters = st.floats(-100, 100)


def through(message):
    """Return a message as it comes out of the wire."""
    return decode(encode(msg=message))["msg"]


@given(st.floats(-MOTION["speed"], MOTION["speed"]), st.floats(-MOTION["turn"], MOTION["turn"]))
def test_velocities_pass(linear, angular):
    velocity = Velocity(linear, angular)
    assert Velocity.decode(through(velocity.encode())) == velocity


@given(anything)
def test_whatever_else_is_a_velocity_within_bounds_or_refused(found):
    try:
        velocity = Velocity.decode(found if isinstance(found, dict) else {"linear": found, "angular": found})
    except Malformed as error:
        assert str(error)
        return
    assert abs(velocity.linear) <= MOTION["speed"]
    assert abs(velocity.angular) <= MOTION["turn"]


@given(st.text(max_size=60) | anything.map(lambda value: json.dumps(value)) | st.binary(max_size=30))
def test_a_frame_is_an_operation_or_a_sentence(data):
    try:
        asked = operation(received(data))
    except Malformed as error:
        assert str(error)
        return
    assert asked.op in (*rosbridge.NAMED_BY, *rosbridge.IGNORED)


@given(meters, meters, st.floats(-math.pi, math.pi), meters, meters)
def test_odometry_passes(x, y, heading, linear, angular):
    sent = Odometry(x, y, heading, Velocity(linear, angular))
    heard = Odometry.decode(through(sent.encode(3, 1700000000.25)))
    assert (heard.x, heard.y, heard.velocity) == (x, y, sent.velocity)
    assert math.cos(heard.heading - heading) == pytest.approx(1)


@given(st.floats(0.04, 0.4), st.floats(0.04, 0.4), st.floats(0.04, 0.4))
def test_ranges_pass_and_keep_their_sides(left, ahead, right):
    message = through(Ranges(left, ahead, right).encode(1, 5.0))
    heard = Ranges.decode(message)
    assert (heard.left, heard.ahead, heard.right) == pytest.approx((left, ahead, right), abs=1e-4)
    assert message["angle_min"] + 2 * message["angle_increment"] == pytest.approx(message["angle_max"])
    assert message["angle_max"] > 0, "the last is on the left, as everywhere in ROS"


@given(st.floats(0, 20), st.floats(-3, 3), st.floats(0, 1))
def test_battery_passes(voltage, current, share):
    heard = BatteryState.decode(through(BatteryState(voltage, current, share, FULL).encode(1, 5.0)))
    assert (heard.voltage, heard.current, heard.share, heard.status) == pytest.approx(
        (voltage, current, share, FULL), abs=1e-3
    )


def test_charging_is_said_only_with_a_current():
    assert recharge_state(1.2, False) == CHARGING
    assert recharge_state(0.7, True) == FULL
    assert recharge_state(0.0, False) == DISCHARGING


def test_pictures_pass_and_others_do_not():
    sent = Picture(b"\xff\xd8 a picture", 1700000000.5)
    assert Picture.decode(through(sent.encode(1))) == sent
    for wrong in ({}, {"format": "png", "data": "/9g="}, {"format": "jpeg", "data": "aGk="}, {"format": "jpeg", "data": "%"}, {"format": "jpeg", "data": 5}, {"format": "jpeg", "data": "A" * 300_000}):  # fmt: skip
        with pytest.raises(Malformed):
            Picture.decode(wrong)


@given(st.integers(0, 2**40), st.integers(0, 2**40), st.booleans(), st.integers(0, LARGEST_EPOCH))
def test_a_status_passes(boot, motion, moving, epoch):
    sent = Status(boot, motion, "held", moving, False, not moving, moving, epoch, 12.5)
    assert Status.decode(through(sent.encode())) == sent


@given(anything)
def test_nonsense_is_refused_by_each_message(found):
    message = found if isinstance(found, dict) else {"pose": found, "ranges": found, "voltage": found, "boot": found}
    for read in (Odometry.decode, Ranges.decode, BatteryState.decode, Status.decode, Picture.decode, epoch_of):
        try:
            read(message)
        except Malformed as error:
            assert str(error)


@pytest.mark.parametrize(
    ("value", "error"),
    [
        (True, Malformed),
        ("1", Malformed),
        (math.nan, Malformed),
        (math.inf, Malformed),
        (None, Malformed),
        (1e308, OutOfBounds),
        (-1, OutOfBounds),
        (10**40, OutOfBounds),
    ],
)
def test_numbers_are_finite_and_bounded(value, error):
    with pytest.raises(error, match="n"):
        numeral({"n": value}, "n", 0, 5, "m")


def test_names_of_ros_2_are_the_same_types():
    frame = json.dumps({"op": "subscribe", "topic": "irat/odom", "type": "nav_msgs/msg/Odometry"})
    assert operation(received(frame)).type == TOPICS["/irat/odom"]
    assert operation(received(frame)).name == "/irat/odom"
    assert all(name.startswith("/irat/") for name in (*TOPICS, *SERVICES))


def test_the_longest_frame_is_read_and_a_longer_one_is_not():
    frame = json.dumps({"op": "status", "msg": ""})
    room = rosbridge.MOST_BYTES - len(frame)
    assert operation(received(frame.replace('""', f'"{"x" * room}"'))).op == "status"
    with pytest.raises(Malformed, match="longer than"):
        operation(received(frame.replace('""', f'"{"x" * (room + 1)}"')))
