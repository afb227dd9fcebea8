"""The hall rover's motor board and its odometry: pure, for any sequence of what it is told."""

from math import cos, degrees, hypot, pi, radians, sin

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.kit.description import load
from simulators.srv1.drive import Drive
from simulators.srv1.odometry import Odometry
from tests.drivers.srv1_wire import TICK_S, Bench

MOTION = load("srv1")["motion"]
per_cent = st.integers(-100, 100)
told = st.one_of(
    st.tuples(st.just("percent"), per_cent, per_cent),
    st.tuples(st.just("velocity"), st.floats(-0.5, 0.5), st.floats(-2.0, 2.0)),
    st.just(("hold",)),
    st.just(("restart",)),
)


@given(st.lists(st.tuples(told, st.integers(1, 80)), max_size=8))
def test_it_never_passes_its_limits_and_each_motion_has_one_end(script):
    notes = []
    bench = Bench(lambda event, **more: notes.append((event, more)))
    drive, before = bench.drive, (0.0, 0.0)
    for (what, *values), ticks in script:
        if what == "velocity":
            drive.velocity(*values, 1, bench.now)
        else:
            getattr(drive, what)(*values)
            before = drive.target
        for _ in range(ticks):
            held = drive.holding
            bench.step()
            assert max(map(abs, drive.target)) <= MOTION["speed"] + 1e-9
            most = MOTION["braking"] * TICK_S + 1e-9
            assert all(abs(new - old) <= most for new, old in zip(drive.target, before, strict=True))
            if held:
                assert all(abs(new) <= abs(old) for new, old in zip(drive.target, before, strict=True))
            before = drive.target
    drive.hold()
    for _ in range(round((MOTION["speed"] / MOTION["braking"] + 0.1) / TICK_S)):
        bench.step()
    assert not drive.moving
    assert not drive.holding
    numbers = {event: [more["motion"] for e, more in notes if e == event] for event in ("motion", "rest", "passed")}
    assert numbers["motion"] == numbers["rest"] == list(range(1, drive.motion + 1))
    assert not numbers["passed"]


@pytest.mark.parametrize("values", [(0.6, 0.0), (0.0, 2.1), (float("nan"), 0.0), (0.0, float("inf")), (1e308, 1e308)])
def test_a_velocity_that_is_none_is_refused(values):
    drive = Drive(lambda *_, **__: None)
    with pytest.raises(ValueError, match="no velocity"):
        drive.velocity(*values, 1, 0.0)
    with pytest.raises(ValueError, match="no power"):
        drive.percent(101, 0)


def test_nothing_that_is_said_during_a_hold_counts():
    bench = Bench(lambda *_, **__: None)
    bench.drive.percent(80, 80)
    for _ in range(100):
        bench.step()
    bench.drive.hold()
    while bench.drive.moving:
        before = bench.drive.target[0]
        bench.drive.velocity(0.4, 0.0, 1, bench.now)
        bench.drive.percent(80, 80)
        bench.step()
        assert bench.drive.target[0] < before or not before
    assert bench.drive.motion == 1


def test_a_fast_curve_keeps_its_radius():
    bench = Bench(lambda *_, **__: None)
    for _ in range(200):
        bench.drive.velocity(0.5, 1.0, 1, bench.now)
        bench.step()
    left, right = bench.drive.target
    assert right == pytest.approx(0.5)
    assert (left + right) / 2 / ((right - left) / 0.2) == pytest.approx(0.5), "the radius: 0.5 m/s by 1 rad/s"


def test_wheels_that_do_not_turn_are_noticed():
    notes = []
    drive = Drive(lambda event, **more: notes.append(event))
    for tick in range(200):
        drive.percent(40, 40)
        drive.step(tick * TICK_S, TICK_S, (0.0, 0.0), True)
    assert notes.count("stalled") == 1
    assert drive.stalled


def test_odometry_goes_where_the_rover_goes_although_its_wheels_slip():
    body, home, dice = load("srv1")["body"], load("srv1")["hall"]["home"], np.random.default_rng(1)
    counts_a_m = body["ticks"] / (2 * pi * body["wheel_radius"])
    x, y, heading, ways = *home, np.zeros(2)

    def compass():
        return (degrees(pi / 2 - heading) + dice.normal(0.0, 2.0)) % 360

    odometry = Odometry((0, 0), compass())
    for part in range(8):
        for _ in range(200):
            ahead, turn = (0.3, 0.0) if part % 2 == 0 else (0.0, radians(45))
            heading += turn * 0.02
            x, y = x + ahead * cos(heading) * 0.02, y + ahead * sin(heading) * 0.02
            rims = np.array([ahead - 1.6 * turn * body["track"] / 2, ahead + 1.6 * turn * body["track"] / 2])
            ways += rims * 0.02  # the rims go 1.6 times as far as the turn needs
            odometry.advance((int(ways[0] * counts_a_m), int(ways[1] * counts_a_m)), compass(), 0.02)
        assert odometry.linear == pytest.approx(ahead, abs=0.03)
        assert odometry.angular == pytest.approx(turn, abs=0.25)
    assert hypot(odometry.x - x, odometry.y - y) < 0.3
    assert abs((odometry.heading - heading + pi) % (2 * pi) - pi) < radians(15)
