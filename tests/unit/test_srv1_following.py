"""How the rover follows a line and knows its place: it arrives, it could always stop, and it is not surer than it is."""

from dataclasses import replace
from math import cos, hypot, pi, remainder, sin, tau

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.description import load
from robots.drivers.srv1.answers import Status
from robots.drivers.srv1.following import REACHED_M, TURN_RAD_S, is_reached, room_ahead, toward, turning
from robots.drivers.srv1.whereabouts import UNKNOWN_M, Whereabouts

STEP_S, FAR_M, STOP_M, CLOSE_M, BRAKING = 0.1, 0.80, 0.15, 0.50, 2.5
AT = st.tuples(st.floats(-5, 5), st.floats(-5, 5))
REST = Status(
    boot=1, epoch=1, motion=0, moving=False, holding=False, end="none", mode="rest", x=1.0, y=1.0, heading=0.0,
    linear=0.0, angular=0.0, infrared=0.8, sonar=5.0, volts=8.0, temperature=20.0, humidity=0.5, light=0.5,
    presence=False, dead_encoders=0, rules=0, permit_ms=0, journal=0, uptime_ms=1000,
)  # fmt: skip


@given(AT, AT, st.floats(-pi, pi), st.floats(0.0, 0.4))
def test_it_arrives_wherever_it_begins(begin, end, heading, lost):
    """Also where the wheels turn less than they are told, as four wheels that slip."""
    pose = (*begin, heading)
    seconds = (hypot(end[0] - begin[0], end[1] - begin[1]) / 0.05 + 20) / STEP_S
    for _ in range(int(seconds)):
        if is_reached(pose, begin, end, passed=False):
            return
        v, w = toward(pose, begin, end, 0.4, FAR_M - STOP_M, BRAKING)
        assert 0.0 <= v <= 0.4
        assert abs(w) <= TURN_RAD_S
        turn = (1 - lost) * w * STEP_S
        middle = pose[2] + turn / 2
        pose = (pose[0] + v * STEP_S * cos(middle), pose[1] + v * STEP_S * sin(middle), remainder(pose[2] + turn, tau))
    raise AssertionError(f"it is at {pose}, not within {REACHED_M} m of {end}")


@given(AT, st.floats(-pi, pi), st.floats(0.0, FAR_M))
def test_it_could_always_stop_before_what_infrared_sees(end, heading, infrared):
    """With a tenth of a second until the next look, and the description's braking."""
    left = hypot(*end)
    room = room_ahead(infrared, 5.0, STOP_M, CLOSE_M, left)
    v, _ = toward((0.0, 0.0, heading), (0.0, 0.0), end, 0.4, room, BRAKING)
    assert v * STEP_S + v * v / (2 * BRAKING) <= max(0.0, infrared - STOP_M) + 0.005 or v == 0.0


@given(st.floats(-pi, pi).filter(lambda left: left != 0))
def test_it_turns_the_way_that_is_left(left):
    """Never slower than the wheels need to come round, never faster than they may."""
    rate = turning(left)
    assert rate * left > 0
    assert 0.3 <= abs(rate) <= TURN_RAD_S


def test_the_numbers_of_the_description_are_the_ones_that_were_judged():
    """The reflex, the range and the braking that this file takes for granted."""
    described = load("srv1")
    assert (described["infrared"]["far"], described["infrared"]["stop"]) == (FAR_M, STOP_M)
    assert described["sonar"]["close"] == CLOSE_M
    assert described["motion"]["braking"] == BRAKING


def test_the_sonar_sees_what_infrared_misses_before_the_end_of_the_line():
    """Black glass, and an edge beside the ray of infrared; a wall behind the place to which it goes is in no way."""
    assert room_ahead(0.8, 0.7, 0.15, 0.5, 2.0) == pytest.approx(0.2)
    assert room_ahead(0.8, 0.4, 0.15, 0.5, 2.0) == 0.0
    assert room_ahead(0.8, 0.4, 0.15, 0.5, 0.3) == pytest.approx(0.65)
    v, w = toward((0.0, 0.0, 0.3), (0.0, 0.0), (2.0, 0.0), 0.4, 0.0, BRAKING)
    assert v == 0.0, "nothing is free ahead"
    assert w < 0.0, "it turns to its line"
    assert toward((0.0, 0.0, 0.0), (0.0, 0.0), (2.0, 0.0), 0.4, 0.0, BRAKING) == (0.0, 0.0)


def test_a_dead_encoder_takes_what_was_known_away():
    where = Whereabouts()
    where.take(REST)
    where.found((5.0, 4.0, 1.0), 0.05, REST)
    where.take(replace(REST, dead_encoders=2))
    assert not where.is_known


@given(st.lists(st.tuples(st.floats(0, 0.05), st.floats(-0.2, 0.2)), min_size=1, max_size=60))
def test_it_gets_less_sure_with_each_metre_and_each_turn(steps):
    """The spread never shrinks by itself; the way is summed up; the pose follows the odometry from where it was found."""
    where, status, way = Whereabouts(), REST, 0.0
    where.take(status)
    assert not where.is_known, "nobody has looked"
    where.found((5.0, 4.0, 1.0), 0.05, status)
    before, x, y, bent = where.spread, 5.0, 4.0, 1.0
    for ahead, turn in steps:
        heading = remainder(status.heading + turn, tau)
        status = replace(
            status, x=status.x + ahead * cos(heading), y=status.y + ahead * sin(heading), heading=heading, motion=1
        )
        where.take(status)
        way += ahead
        x, y = x + ahead * cos(heading + bent), y + ahead * sin(heading + bent)
        assert before <= where.spread <= UNKNOWN_M
        before = where.spread
    assert abs(where.driven - way) < 1e-6
    assert hypot(where.pose(status)[0] - x, where.pose(status)[1] - y) < 1e-6
    where.take(replace(REST, boot=2))
    assert not where.is_known, "it was switched on again, and may stand anywhere"


def test_what_is_known_outlives_the_owner_and_not_the_rover(tmp_path):
    """The next owner knows the place, less surely if the rover has moved unseen; another start, or rubbish, nothing."""
    file = tmp_path / "whereabouts.json"
    first = Whereabouts(file)
    first.take(REST)
    first.found((5.0, 4.0, 1.0), 0.05, REST)
    for status, most in ((REST, 0.051), (replace(REST, motion=7, x=1.5), 0.3)):
        again = Whereabouts(file)
        again.take(status)
        assert again.is_known
        assert 0.05 <= again.spread <= most
    moved = Whereabouts(file)
    moved.take(replace(REST, x=2.0, motion=3))
    assert moved.pose(replace(REST, x=2.0))[:2] == (5.0 + cos(1.0), 4.0 + sin(1.0))
    other = Whereabouts(file)
    other.take(replace(REST, boot=2))
    assert not other.is_known
    for rubbish in ("", "{", "[]", '{"odometry": [NaN, 0, 0]}', '{"spread": 1e999}', "9" * 5000):
        file.write_text(rubbish)
        again = Whereabouts(file)
        again.take(REST)
        assert not again.is_known


def test_odometry_that_jumps_is_no_way():
    """It has begun anew: the place is not known any more."""
    where = Whereabouts()
    where.take(REST)
    where.found((5.0, 4.0, 1.0), 0.05, REST)
    where.take(replace(REST, x=9.0))
    assert (where.driven, where.is_known) == (0.0, False)
