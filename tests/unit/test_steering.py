"""Local navigation: the six states in their order, bounds for any input, and a drive that touches no wall."""

import math
import random
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.kit.rovers.steering import Limits, Memory, Sensed, steer
from tests.unit.ratslam_world import INNER, OUTER, World

KEPT = Limits()
OPEN = Sensed(0.4, 0.4, 0.4, 0.15, 0.0, 0.0)
MOVING = Memory(v=0.15)
DT = 0.1
ranges = st.none() | st.floats() | st.floats(0.03, 0.4)
memories = st.builds(
    Memory,
    v=st.floats(-0.05, 0.15),
    w=st.floats(-1.5, 1.5),
    stalled_s=st.floats(0, 1),
    reversing_s=st.floats(-1.2, 1.2),
    side=st.sampled_from([-1, 0, 1]),
    behind=st.booleans(),
    wander=st.floats(-3, 3),
    wander_s=st.floats(0, 12),
    bumps=st.lists(st.tuples(st.floats(-1, 1), st.floats(-1, 1), st.floats(0, 25)), max_size=12).map(tuple),
    points=st.lists(st.tuples(st.floats(-0.4, 0.4), st.floats(-0.4, 0.4)), max_size=60).map(tuple),
)


def first(sensed, memory=MOVING):
    return steer(sensed, memory, DT, 0.5)[0]


@given(ranges, ranges, ranges, st.floats(-1, 1), st.floats(-5, 5), st.none() | st.floats(-7, 7), memories, st.floats(0, 1))  # fmt: skip
def test_a_velocity_is_bounded_whatever_is_sensed(left, front, right, v, w, bearing, memory, dt):
    chosen, after = steer(Sensed(left, front, right, v, w, bearing), memory, dt, 0.3)
    assert -KEPT.slow <= chosen.v <= min(KEPT.cruise, max(0.0, memory.v) + KEPT.step * dt)
    assert abs(chosen.w) <= KEPT.turn
    assert (after.v, after.w) == (chosen.v, chosen.w)
    assert len(after.points) <= KEPT.points


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf, 1e308, "left"])
@pytest.mark.parametrize("which", ["v", "w", "bearing"])
def test_a_speed_or_bearing_that_is_none_is_refused(bad, which):
    with pytest.raises((ValueError, TypeError), match=r"must be a number|str"):
        first(replace(OPEN, **{which: bad}))


@pytest.mark.parametrize(("dt", "dice"), [(math.nan, 0.5), (-0.1, 0.5), (1e308, 0.5), (0.1, 1.0), (0.1, math.nan)])
def test_a_time_step_that_is_none_is_refused(dt, dice):
    with pytest.raises(ValueError, match="dt must"):
        steer(OPEN, MOVING, dt, dice)


@pytest.mark.parametrize(
    ("sensed", "state"),
    [
        (OPEN, "default"),
        (replace(OPEN, left=0.2, bearing=0.3), "wall"),
        (replace(OPEN, left=0.2, bearing=-0.3), "default"),  # the wall is not on the goal's side
        (replace(OPEN, left=0.2, right=0.2), "corridor"),
        (replace(OPEN, left=0.2, right=0.2, bearing=3.0), "behind"),
        (replace(OPEN, left=0.2, right=0.2, bearing=3.0, front=0.1), "obstacle"),
    ],
)
def test_each_state_comes_before_the_ones_below(sensed, state):
    assert first(sensed).state == state


def test_a_stall_comes_before_all_others():
    """Half a second after the wheels stopped doing what they are told, whatever the ranges say."""
    memory, states = MOVING, []
    while "stall" not in states:
        chosen, memory = steer(replace(OPEN, v=0.0), memory, DT, 0.5)
        states.append(chosen.state)
    assert 4 <= len(states) <= 6
    chosen, _ = steer(Sensed(0.2, 0.1, 0.2, -0.05, 0.0, 3.0), memory, DT, 0.5)
    assert chosen.state == "stall" and -KEPT.slow <= chosen.v < 0


def test_a_wall_too_low_to_see_is_met_and_then_turned_from():
    """A kerb at x = 0.3 m, which no sensor sees: the robot does not spend its time on driving at it again and again."""
    x, y, heading, v, w, memory, stalls, metres, last = 0.0, 0.0, 0.2, 0.0, 0.0, Memory(), 0, 0.0, ""
    for n in range(250):
        chosen, memory = steer(Sensed(0.4, 0.4, 0.4, v, w, None), memory, DT, (0.5 + 0.01 * n) % 1)
        stalls += chosen.state == "stall" != last
        last, v, w = chosen.state, chosen.v, chosen.w
        if x + 0.085 * abs(math.cos(heading)) > 0.3 and v * math.cos(heading) > 0:
            v = 0.0
        heading += w * DT
        x, y = x + v * DT * math.cos(heading), y + v * DT * math.sin(heading)
        metres += abs(v) * DT
    assert 1 <= stalls <= 4
    assert metres > 1.5


def test_a_robot_that_stalls_in_reverse_goes_ahead():
    memory, seen = Memory(reversing_s=1.2, v=-0.05), []
    for _ in range(8):
        chosen, memory = steer(replace(OPEN, v=0.0), memory, DT, 0.5)
        seen.append(chosen.v)
    assert seen[0] < 0 < seen[-1]


def test_the_signs():
    """Left is positive: towards a goal on the left, to the middle of a corridor, away from what is near."""
    assert first(replace(OPEN, bearing=0.5)).w > 0 > first(replace(OPEN, bearing=-0.5)).w
    assert first(replace(OPEN, left=0.25, right=0.15)).w > 0
    assert first(replace(OPEN, left=0.15, right=0.25)).w < 0
    assert first(replace(OPEN, left=0.05)).w < 0 < first(replace(OPEN, right=0.05)).w
    assert first(replace(OPEN, front=0.1, left=0.3, right=0.1)).w > 0
    assert first(replace(OPEN, bearing=2.5)).w > 0 > first(replace(OPEN, bearing=-2.5)).w
    assert first(replace(OPEN, left=0.15, bearing=0.5)).w < 0 < first(replace(OPEN, left=0.25, bearing=0.5)).w


def test_with_a_dead_front_sensor_it_creeps_and_with_all_dead_it_rests():
    assert 0 < first(replace(OPEN, front=None)).v <= KEPT.slow
    assert first(replace(OPEN, front=math.nan)).v <= KEPT.slow
    blind = first(Sensed(None, math.nan, -1.0, 0.1, 0.0, 0.0))
    assert (blind.state, blind.v, blind.w) == ("blind", 0.0, 0.0)


def test_a_turn_away_from_an_obstacle_goes_on_to_one_side():
    memory, turns = MOVING, []
    for n in range(10):  # the sides change places, as they do in a corner
        near, far = (0.15, 0.2) if n % 2 else (0.2, 0.15)
        chosen, memory = steer(Sensed(near, 0.1, far, 0.0, 1.0, 0.0), memory, DT, 0.5)
        turns.append(chosen.w > 0)
    assert len(set(turns)) == 1


def test_it_does_not_turn_into_a_wall_that_its_sensors_have_passed():
    """The end of a wall 3 cm beside the robot lies behind the sensors, and the goal round the corner."""
    memory = replace(MOVING, points=((0.03, 0.075), (0.0, 0.075)))
    assert first(replace(OPEN, bearing=1.0), memory).w == 0.0
    assert first(replace(OPEN, bearing=-1.0), memory).w < 0
    assert first(replace(OPEN, bearing=1.6), memory).v == KEPT.slow  # on, although the goal is straight to the side
    behind = replace(MOVING, points=((-0.15, 0.075),))
    assert first(replace(OPEN, bearing=1.0), behind).w > 0


def test_exploring_draws_directions_and_keeps_each_for_a_while():
    memory, drawn = Memory(), []
    for n in range(600):
        _, memory = steer(replace(OPEN, w=memory.w, bearing=None), memory, DT, (n * 0.37) % 1)
        drawn.append(memory.wander_s)
    renewed = sum(b > a for a, b in pairwise(drawn))
    assert 3 <= renewed <= 8


class Plane:
    """The ring of corridors, three sensors of 4 mm noise, and a body of 17 x 10 cm."""

    def __init__(self, dead=None):
        self.world, self.dice, self.dead = World(), random.Random(1), dead

    def sensed(self, x, y, heading):
        at = np.array([x + 0.035 * math.cos(heading), y + 0.035 * math.sin(heading)])
        found = []
        for angle in (heading + math.pi / 4, heading, heading - math.pi / 4):
            ray, to = np.array([math.cos(angle), math.sin(angle)]), self.world.begin - at
            cross = ray[0] * self.world.along[:, 1] - ray[1] * self.world.along[:, 0]
            with np.errstate(all="ignore"):
                far = (to[:, 0] * self.world.along[:, 1] - to[:, 1] * self.world.along[:, 0]) / cross
                part = (to[:, 0] * ray[1] - to[:, 1] * ray[0]) / cross
            far = far[(far > 0) & (part >= 0) & (part <= 1)].min(initial=0.4)
            found.append(min(0.4, max(0.04, far + self.dice.gauss(0, 0.004))))
        return [None if n == self.dead else r for n, r in enumerate(found)]

    @staticmethod
    def room(x, y, heading):
        """Return the least distance (m) of the body's rim to a wall."""
        rim = [(0.085, 0.05), (0.085, -0.05), (-0.085, 0.05), (-0.085, -0.05), (0.085, 0), (0, 0.05), (0, -0.05)]
        spots = [(x + a * math.cos(heading) - b * math.sin(heading), y + a * math.sin(heading) + b * math.cos(heading)) for a, b in rim]  # fmt: skip
        return min(
            min(OUTER[0] - abs(px), OUTER[1] - abs(py), max(abs(px) - INNER[0], abs(py) - INNER[1])) for px, py in spots
        )

    def drive(self, seconds, bearing=None):
        """Drive; return the metres, the touches of a wall, and the last place."""
        x, y, heading, v, w, memory = -0.5, -0.775, 0.3, 0.0, 0.0, Memory()
        metres = touches = 0
        for _ in range(round(seconds / DT)):
            wanted = bearing(x, y, heading) if bearing else None
            sensed = Sensed(*self.sensed(x, y, heading), v, w, wanted)
            chosen, memory = steer(sensed, memory, DT, self.dice.random())
            v += max(-0.05, min(chosen.v - v, 0.05))
            w += max(-1.0, min(chosen.w - w, 1.0))
            at = x + v * DT * math.cos(heading), y + v * DT * math.sin(heading), heading + w * DT
            if (room := self.room(*at)) > 0 or room > self.room(x, y, heading):
                x, y, heading = at
                metres += abs(v) * DT
            else:
                touches, v, w = touches + 1, 0.0, 0.0
        return metres, touches, (x, y)


def test_a_goal_that_stays_behind_whatever_it_does_is_left_alone_for_a_while():
    memory, metres, v = Memory(), 0.0, 0.0
    for n in range(200):
        chosen, memory = steer(replace(OPEN, v=v, w=memory.w, bearing=3.0), memory, DT, (n * 0.37) % 1)
        v = chosen.v
        metres += v * DT
        assert metres == 0.0 or n * DT > KEPT.idle_s - 0.5
    assert metres > 0.5


def test_exploring_touches_no_wall():
    metres, touches, _ = Plane().drive(90)
    assert metres > 8 and touches == 0


@pytest.mark.parametrize("dead", [0, 1, 2])
def test_with_one_dead_sensor_it_still_gets_about(dead):
    metres, _, _ = Plane(dead).drive(60)
    assert metres > 2


def test_a_goal_on_the_other_side_of_a_corner_is_reached():
    goal = (0.875, 0.3)

    def bearing(x, y, heading):  # waypoints along the corridor, as a route would give
        to = goal if x > 0.7 else (0.875, -0.775)
        return math.remainder(math.atan2(to[1] - y, to[0] - x) - heading, 2 * math.pi)

    _, touches, at = Plane().drive(17.5, bearing)
    assert math.dist(at, goal) < 0.35 and touches == 0
