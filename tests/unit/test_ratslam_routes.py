"""Routes over the experience map: the same as another library's, and a guide that follows them."""

import math

import networkx as nx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robots.kit.slam.experiences import ExperienceMap, composed, inverted
from robots.kit.slam.pruning import pruned
from robots.kit.slam.routes import FINE_M, SHORTEST_S, Guide, plan
from robots.kit.slam.settings import MapSettings

HERE = (0.0, 0.0, 0.0)


def line(count, apart=0.05, seconds=0.5):
    """Return a map of experiences up the page, the robot at its end."""
    held = ExperienceMap(MapSettings())
    held.create(0, HERE)
    for n in range(1, count):
        held.move(apart, 0.0, seconds)
        held.create(n, HERE)
    return held


def ring(count=40, side=0.1):
    """Return a map of a square loop that the robot has closed."""
    held = ExperienceMap(MapSettings())
    held.create(0, HERE)
    for n in range(1, count + 1):
        held.move(side, math.pi / 2 if n % (count // 4) == 0 else 0.0, 1.0)
        _ = held.meet(0, HERE) if n == count else held.create(n, HERE)
    return held


@settings(max_examples=40, deadline=None)
@given(st.lists(st.tuples(st.integers(0, 30), st.floats(0, 9)), min_size=1, max_size=60), st.integers(0, 40))
def test_a_route_is_the_one_of_networkx(moves, goal):
    held = ExperienceMap(MapSettings())
    held.create(0, HERE)
    for number, seconds in moves:
        held.move(0.1, 0.3, seconds)
        _ = held.meet(number, HERE) if number < held.count and number != held.current else held.create(0, HERE)
    graph = nx.Graph()
    graph.add_nodes_from(range(held.count))
    for n in range(held.linked):
        graph.add_edge(int(held.sources[n]), int(held.targets[n]), s=max(float(held.durations[n]), SHORTEST_S))
    route = plan(held, goal)
    if goal >= held.count:
        assert route is None
        return
    assert route.seconds == pytest.approx(nx.dijkstra_path_length(graph, held.current, goal, weight="s"))
    assert (route.ids[0], route.ids[-1]) == (held.current, goal)
    driven = sum(graph.edges[a, b]["s"] for a, b in zip(route.ids, route.ids[1:], strict=False))
    assert driven == pytest.approx(route.seconds)
    assert route.limit_s == pytest.approx(3 * route.seconds + 30)


def test_the_quicker_way_round_is_taken_not_the_shorter():
    held = ring()
    held.durations[:5] = 30.0  # clutter on the way
    assert plan(held, 5).ids == (0, *range(39, 4, -1))
    assert plan(held, 30).ids == (0, *range(39, 29, -1))


def test_without_a_map_or_a_link_there_is_no_route():
    held = ExperienceMap(MapSettings())
    assert plan(held, 0) is None
    held = line(4)
    held.linked = 2
    assert plan(held, 0) is None and Guide(0).look(held) is None


def test_the_waypoint_is_the_last_point_of_the_route_within_twenty_centimetres():
    held = line(20)
    guide = Guide(0)
    seen = guide.look(held)
    assert seen.waypoint == 19 - 4 and not seen.reached
    assert abs(seen.bearing) == pytest.approx(math.pi) and 0.2 - FINE_M <= seen.distance < 0.2


@settings(max_examples=20, deadline=None)
@given(st.floats(0.21, 0.9), st.floats(-0.06, 0.06))
def test_links_longer_than_the_robot_looks_ahead_are_followed_to_the_next_experience(apart, beside):
    """As on a pruned map: beside an experience that it has passed the robot is led on, not back to it."""
    held = line(5, apart)
    guide, gone = Guide(0), 0.0
    held.move(0.0, math.pi / 2, 1.0)
    held.move(beside, 0.0, 1.0)
    while not (seen := guide.look(held)).reached:
        held.move(0.0, seen.bearing, 0.1)
        held.move(0.02, 0.0, 0.1)
        gone += 0.02
        assert gone < 4 * apart + 0.5
        pose = held.pose()
        near = int(np.argmin(np.hypot(*(held.poses[:5, :2] - pose[:2]).T)))
        if math.dist(held.poses[near, :2], pose[:2]) < 0.05:
            held.current, held.since = near, composed(inverted(held.pose_of(near)), pose)


def test_a_waypoint_is_not_taken_across_a_wall():
    """Two corridors 15 cm apart, joined 1 m up: the route goes up and comes down, and so must the robot."""
    held = line(21)
    for n in range(4):
        held.move(0.05, math.pi / 2 if n in (0, 3) else 0.0, 0.5)
        held.create(30 + n, HERE)
    for n in range(20):
        held.move(0.05, 0.0, 0.5)
        held.create(40 + n, HERE)
    goal = held.count - 1
    held.current, held.since = 0, HERE
    seen = Guide(goal).look(held)
    assert np.hypot(*(held.poses[goal, :2] - held.poses[0, :2])) < 0.2
    assert seen.waypoint < 5


@settings(max_examples=20, deadline=None)
@given(st.integers(1, 39), st.floats(-0.03, 0.03))
def test_who_follows_the_guide_arrives(goal, beside):
    """A robot that goes to each waypoint, a little beside it, is at the goal before its limit."""
    held = ring()
    guide, gone = Guide(goal), 0
    while not (seen := guide.look(held)).reached:
        at = int(np.flatnonzero(held.ids[: held.count] == seen.waypoint)[0])
        held.current, held.since = at, (0.0, beside, 0.0)
        gone += 1
        assert gone < 40
    assert seen.route.ids[-1] == goal
    assert np.hypot(*(held.poses[held.current, :2] - held.poses[goal, :2])) < 0.1


def test_the_guide_plans_anew_when_its_route_is_left_or_pruned():
    held = ring()
    guide = Guide(10)
    first = guide.look(held).route
    held.current, held.since = 30, HERE
    second = guide.look(held).route
    assert second.ids[0] == 30 and first.ids != second.ids
    held.settings = MapSettings(square_m=0.25)
    pruned(held, frozenset({10}), lambda kept: None)
    third = guide.look(held).route
    assert set(third.ids) <= set(held.ids[: held.count].tolist()) and third.ids[-1] == 10


def test_a_goal_that_was_pruned_has_no_way():
    held = ring()
    held.settings = MapSettings(square_m=5.0, headings=1)
    pruned(held, frozenset(), lambda kept: None)
    assert Guide(20).look(held) is None
