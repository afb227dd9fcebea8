"""How the rover follows a line and knows its place: it arrives, it could always stop, and it is not surer than it is."""

from dataclasses import replace
from math import cos, hypot, pi, remainder, sin, tau

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.kit.description import load
from robots.kit.drivers.srv1.answers import Status
from robots.kit.drivers.srv1.following import REACHED_M, TURN_RAD_S, is_reached, room_ahead, toward, turning
from robots.kit.drivers.srv1.hall import hall
from robots.kit.drivers.srv1.rounds import Round
from robots.kit.drivers.srv1.whereabouts import KNOWN_M, OF_RANGE, TOLERANCE_M, UNKNOWN_M, Whereabouts, sonar_at
from simulators.srv1.patrol import Patrol

STEP_S, FAR_M, STOP_M, CLOSE_M, BRAKING = 0.1, 0.80, 0.15, 0.50, 2.5
AT = st.tuples(st.floats(-5, 5), st.floats(-5, 5))
REST = Status(  # with somebody before it, so that sonar says nothing of its place
    boot=1, epoch=1, motion=0, moving=False, holding=False, end="none", mode="rest", x=1.0, y=1.0, heading=0.0,
    linear=0.0, angular=0.0, infrared=0.8, sonar=0.15, volts=8.0, temperature=20.0, humidity=0.5, light=0.5,
    presence=True, dead_encoders=0, rules=0, permit_ms=0, journal=0, uptime_ms=1000,
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
    where.take_scan((5.0, 4.0, 1.0), 0.05, REST)
    where.take(replace(REST, dead_encoders=2))
    assert not where.is_known


@given(st.lists(st.tuples(st.floats(0, 0.05), st.floats(-0.2, 0.2)), min_size=1, max_size=60))
def test_it_gets_less_sure_with_each_metre_and_each_turn(steps):
    """The spread never shrinks by itself; the way is summed up; the pose follows the odometry from where it was found."""
    where, status, way = Whereabouts(), REST, 0.0
    where.take(status)
    assert not where.is_known, "nobody has looked"
    where.take_scan((5.0, 4.0, 1.0), 0.05, status)
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
    first.take_scan((5.0, 4.0, 1.0), 0.05, REST)
    for status, most in ((REST, 0.051), (replace(REST, motion=7, x=1.5), 0.3)):
        again = Whereabouts(file)
        again.take(status)
        assert again.is_known
        assert 0.05 <= again.spread <= most
    moved = Whereabouts(file)
    moved.take(replace(REST, x=2.0, motion=3))
    assert moved.pose(replace(REST, x=2.0))[:2] == (5.0 + cos(1.0), 4.0 + sin(1.0))
    unheard = Whereabouts(file)
    unheard.take(replace(REST, motion=3, uptime_ms=21_000))
    assert unheard.spread > 0.4, "in 20 s it may have come back to where it was by any way"
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
    where.take_scan((5.0, 4.0, 1.0), 0.05, REST)
    where.take(replace(REST, x=9.0))
    assert (where.driven, where.is_known) == (0.0, False)


def patrolled(seconds, ahead=lambda pose: FAR_M):
    """Return the nodes to which a round leads a rover, and its poses, one each step; `ahead`: what infrared sees."""
    led, course = Round(), Patrol()
    pose, goals, poses = (1.0, 1.0, 0.5), [], []
    for _ in range(int(seconds / STEP_S)):
        aside = led.aside(pose, ahead(pose) < STOP_M + 0.03)
        if not goals or led.goal != goals[-1]:
            goals.append(led.goal)
        v, w = course.velocity(FAR_M, FAR_M, 0.0, 0.4, aside)
        turn = w * STEP_S
        middle = pose[2] + turn / 2
        pose = (pose[0] + v * STEP_S * cos(middle), pose[1] + v * STEP_S * sin(middle), remainder(pose[2] + turn, tau))
        poses.append(pose)
    return goals, poses


def test_a_round_leads_past_every_node_and_leaves_room():
    """In ten minutes, with the firmware's own steering; nothing is passed nearer than the hull is wide."""
    goals, poses = patrolled(600)
    assert set(goals) == {node.name for node in hall().nodes}
    assert min(hall().distance(x, y) for x, y, _ in poses) > 0.2


def test_a_round_turns_back_before_what_stands_in_its_way():
    """Something was put between Door and West: the round goes on elsewhere, and comes no nearer."""

    def ahead(pose):
        looks_up = cos(pose[2] - pi / 2) > 0.8
        return max(0.1, min(2.5 - pose[1], FAR_M)) if pose[0] < 2.0 and pose[1] < 2.5 and looks_up else FAR_M

    goals, poses = patrolled(600, ahead)
    assert len(set(goals)) > 7
    assert not any(x < 2.0 and 2.4 < y < 2.6 and cos(heading - pi / 2) > 0.8 for x, y, heading in poses)


def placed(status=REST, spread=0.05):
    where = Whereabouts()
    where.take(status)
    where.take_scan((1.0, 1.0, 0.0), spread, status)
    return where


def shown(where, status, times):
    for number in range(1, times + 1):
        where.take(replace(status, uptime_ms=status.uptime_ms + 100 * number))
    return where.spread


@given(st.floats(-10, 10), st.booleans())
def test_sonar_that_contradicts_the_map_makes_it_less_sure_until_they_agree(off, presence):
    """A thing that is nearer than the map says may be a person who stands there."""
    expected = sonar_at((1.0, 1.0, 0.0))
    sees = min(max(expected + off, 0.15), 10.0)
    where, off = placed(), abs(sees - expected)
    spread, bound = shown(where, replace(REST, sonar=sees, presence=presence), 2000), TOLERANCE_M + OF_RANGE * expected
    if (sees < expected and presence) or off < bound:
        assert spread == pytest.approx(0.05)
    else:
        assert min(off, bound + 2 * KNOWN_M) <= bound + 2 * spread + 0.1, "it is not surer than what it sees"


def test_agreement_gives_back_what_doubt_has_cost():
    where = placed()
    assert shown(where, replace(REST, sonar=10.0), 30) > 0.3
    agrees = replace(REST, sonar=sonar_at((1.0, 1.0, 0.0)), uptime_ms=9000)
    assert shown(where, agrees, 60) == pytest.approx(0.05)


def test_beside_a_wall_each_metre_costs_more():
    """Its side may touch the wall, and its wheels slide."""

    def driven(y):
        where = Whereabouts()
        where.take(REST)
        where.take_scan((1.0, y, 0.0), 0.05, REST)
        for number in range(1, 101):
            where.take(replace(REST, x=1.0 + 0.04 * number, uptime_ms=1000 + 100 * number))
        return where.spread

    assert driven(0.15) > driven(0.5) + 0.2
