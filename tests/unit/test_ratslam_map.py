"""The experience map: links, relaxation, pruning, and what is streamed of it."""

import math

import networkx as nx
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from robots.kit.slam.angles import wrapped
from robots.kit.slam.experiences import START, ExperienceMap, composed, inverted
from robots.kit.slam.pruning import contract, pruned, standing
from robots.kit.slam.relaxing import sine_cosine
from robots.kit.slam.routes import plan
from robots.kit.slam.settings import MapSettings
from robots.kit.slam.stream import ChangeLog

HERE = (0.0, 0.0, 0.0)
poses = st.tuples(st.floats(-5, 5), st.floats(-5, 5), st.floats(-math.pi, math.pi))
steps = st.lists(st.tuples(st.floats(0, 0.2), st.floats(-1, 1), st.integers(0, 12)), min_size=1, max_size=40)


def driven(moves, kept=None):
    """Return a map made by driving; a number below the count of experiences meets that one, another makes one."""
    held = ExperienceMap(kept or MapSettings())
    held.create(0, HERE)
    for distance, turn, number in moves:
        held.move(distance, turn, 0.5)
        if number < held.count and number != held.current:
            held.meet(number, HERE)
        else:
            held.create(held.count, HERE)
        held.relax()
    return held


def graph(held):
    made = nx.Graph()
    made.add_nodes_from(held.ids[: held.count].tolist())
    made.add_edges_from(
        zip(held.ids[held.sources[: held.linked]].tolist(), held.ids[held.targets[: held.linked]].tolist(), strict=True)
    )
    return made


@given(poses, poses)
def test_a_pose_seen_from_another_and_back(a, b):
    seen = composed(inverted(a), composed(a, b))
    assert seen == pytest.approx((b[0], b[1], wrapped(b[2])), abs=1e-9) or abs(abs(seen[2]) - math.pi) < 1e-9


@given(st.floats(-1e6, 1e6))
def test_an_angle_stays_the_same_angle(angle):
    assert -math.pi - 1e-9 <= wrapped(angle) <= math.pi + 1e-9
    assert math.cos(wrapped(angle)) == pytest.approx(math.cos(angle), abs=1e-6)


@given(st.floats(-20, 20))
@example(math.pi / 4)
@example(-3 * math.pi / 4)
def test_sine_and_cosine_of_the_relaxation_are_the_library_s(angle):
    assert sine_cosine(angle) == pytest.approx((math.sin(angle), math.cos(angle)), abs=1e-15)


@settings(max_examples=35, deadline=None)
@given(steps)
def test_relaxing_keeps_every_pose_finite_and_every_two_linked_once(moves):
    held = driven(moves)
    for _ in range(20):
        held.relax()
    assert np.isfinite(held.poses[: held.count]).all()
    assert (np.abs(held.poses[: held.count, 2]) <= math.pi).all()
    pairs = {tuple(sorted(pair)) for pair in zip(held.sources[: held.linked], held.targets[: held.linked], strict=True)}
    assert len(pairs) == held.linked
    assert (held.durations[: held.linked] > 0).all()
    assert nx.is_connected(graph(held))


def test_a_chain_without_a_loop_has_nothing_to_relax():
    held = driven([(0.1, 0.3, 99)] * 10)
    before = held.poses[: held.count].copy()
    for _ in range(10):
        held.relax()
    np.testing.assert_allclose(held.poses[: held.count], before, atol=1e-12)


def test_a_square_with_wrong_odometry_closes_and_its_error_is_shared():
    """Four sides of 1 m, each corner 5 degrees short: dead reckoning ends 0.25 m off, the map does not."""
    held = ExperienceMap(MapSettings())
    held.create(0, HERE)
    for n in range(1, 40):
        held.move(0.1, math.radians(85) if n % 10 == 0 else 0.0, 1.0)
        held.create(n, HERE)
    held.move(0.1, math.radians(85), 1.0)
    open_m = math.dist(held.pose()[:2], START[:2])
    assert open_m > 0.2
    assert held.meet(0, HERE)
    for _ in range(300):
        held.relax()
    poses = held.poses[: held.count]
    gap = math.dist(poses[-1, :2], poses[0, :2])
    assert gap == pytest.approx(0.1, abs=0.02)
    sides = [math.dist(poses[10 * n, :2], poses[10 * n + 10, :2]) for n in range(3)]
    assert sides == pytest.approx([1, 1, 1], abs=0.1)


def test_the_robot_is_linked_from_where_it_stands_when_it_meets_a_place():
    held = ExperienceMap(MapSettings())
    held.create(0, HERE)
    held.move(1.0, 0.0, 2.0)
    held.create(1, HERE)
    held.move(-0.95, 0.0, 2.0)
    assert not held.meet(0, (0.05, 0.0, 0.0))  # linked before
    assert held.pose() == pytest.approx(composed(START, (0.05, 0.0, 0.0)))
    held.move(0.45, math.pi / 2, 3.0)
    held.create(2, HERE)
    assert held.linked == 2
    assert held.durations[:2].tolist() == [2.0, 3.0]


def test_a_long_rest_counts_as_ten_seconds():
    held = ExperienceMap(MapSettings())
    held.create(0, HERE)
    held.move(0.1, 0.0, 1.0)
    for _ in range(7200):
        held.move(0.0, 0.0, 1.0)
    held.move(0.1, 0.0, 1.0)
    held.create(1, HERE)
    assert held.durations[0] == pytest.approx(12.0)


@settings(max_examples=35, deadline=None)
@given(steps, st.frozensets(st.integers(0, 40), max_size=4), st.floats(0.05, 1.0))
def test_pruning_leaves_one_a_place_connected_and_keeps_what_is_protected(moves, protected, square):
    held = driven(moves, MapSettings(square_m=square, headings=4))
    ids, count, current = set(held.ids[: held.count].tolist()), held.count, int(held.ids[held.current])
    dropped = []
    poses = {i: held.pose_of(n) for n, i in enumerate(held.ids[:count].tolist())}
    heirs, numbers = pruned(held, protected, dropped.append)
    left = held.ids[: held.count].tolist()
    assert heirs.keys() == ids - set(left) and set(left) <= ids and set(heirs.values()) <= set(left)
    assert all(math.dist(poses[old][:2], poses[heir][:2]) < square * math.sqrt(2) for old, heir in heirs.items())
    assert protected & ids <= set(left) and int(held.ids[held.current]) == current
    assert nx.is_connected(graph(held)) and nx.number_of_selfloops(graph(held)) == 0
    assert sorted(numbers.values()) == list(range(len(dropped[0])))
    assert np.isfinite(held.poses[: held.count]).all() and np.isfinite(held.measured[: held.linked]).all()
    assert len(held.pairs) == held.linked
    if not protected:
        assert pruned(held, protected, dropped.append)[0] == {}


def twice(count=20, apart=0.04):
    """Return a map of a corridor that was driven twice, seen as the same at its two ends alone."""
    held = driven([(apart, 0.0, 99)] * (count - 1))
    held.poses[:count] = [composed((0.01, 0.0, 0.1), (apart * n, 0.01, 0.0)) for n in range(count)]
    held.meet(0, (0.01, 0.01, 0.0), link=False)
    for n in range(1, count):
        held.move(apart, 0.0, 0.5)
        _ = held.meet(count - 1, (0.01, 0.01, 0.0)) if n == count - 1 else held.create(100 + n, HERE)
        held.relax()
    return held


def test_pruning_keeps_every_link_short_and_as_long_as_it_took():
    """The links of a drive that goes are those of the later one beside it, not one from end to end."""
    held = twice()
    first, last = held.pose_of(0), held.pose_of(19)
    length, took = math.dist(first[:2], last[:2]), plan(held, 0).seconds
    pruned(held, frozenset({0, 19}), lambda kept: None)
    assert held.count < 24
    assert held.measured[: held.linked, 0].max() < 0.05 * math.sqrt(8)
    assert held.poses[0] == pytest.approx(first) and plan(held, 0).seconds == pytest.approx(took, rel=0.25)
    for _ in range(50):
        held.relax()
    ends = held.poses[[0, int(np.flatnonzero(held.ids[: held.count] == 19)[0])], :2]
    assert math.dist(*ends) == pytest.approx(length, abs=0.01)


def test_a_link_that_is_handed_on_leads_where_it_led():
    held = driven([(0.3, 0.2, 99)] * 8)
    stand = np.arange(held.count)
    stand[3] = 4
    contract(held, stand)
    assert (held.count, held.linked) == (8, 7)
    for n in range(held.linked):
        on, to = held.pose_of(int(held.sources[n])), held.pose_of(int(held.targets[n]))
        seen = composed(inverted(on), to)
        assert held.measured[n] == pytest.approx((math.hypot(*seen[:2]), math.atan2(seen[1], seen[0]), seen[2]))
    assert sorted(held.durations[: held.linked].tolist())[-1] == pytest.approx(1.0, abs=0.02)


@pytest.mark.parametrize("back", [False, True])
def test_a_link_that_was_handed_on_is_measured_anew_and_no_other(back):
    held = driven([(0.3, 0.0, 99)] * 4)
    held.poses[2, :2] += (0.05, 0.02)  # the map's error, which the links that are handed on take over
    stand = np.arange(held.count)
    stand[2] = 1
    contract(held, stand)
    handed = held.pairs[1, 2]
    assert held.taken[: held.linked].tolist() == [n != handed for n in range(held.linked)]
    before = held.measured[: held.linked].copy()
    on, to = (2, 1) if back else (1, 2)
    held.meet(on, HERE, link=False)
    held.move(0.6, 0.0, 0.5)
    assert held.meet(to, HERE) is False, "no new link"
    seen = held.measured[handed, 0], held.measured[handed, 1] % (2 * math.pi)
    assert seen == pytest.approx((0.6, math.pi if back else 0.0))
    assert held.durations[handed] == 0.5
    assert (held.taken[: held.linked].all(), held.linked) == (True, len(before))
    others = np.arange(held.linked) != handed
    assert (held.measured[: held.linked][others] == before[others]).all()
    held.meet(on, HERE, link=False)
    held.move(9.0, 0.0, 0.5)
    held.meet(to, HERE)
    assert held.measured[handed, 0] == pytest.approx(0.6), "the first measurement stays"


def test_two_places_that_overlap_on_a_wrong_map_both_stay():
    """Two ends of a corridor that the map, wrongly, shows at one place; once a loop tells that they are one, one goes."""
    held = driven([(0.3, 0.0, 99)] * 10)
    held.poses[10] = held.poses[0]
    assert pruned(held, frozenset(), lambda kept: None)[0] == {}
    held.move(0.01, 0.0, 0.5)
    held.meet(0, HERE)
    held.move(0.3, 0.0, 0.5)
    held.meet(1, HERE)
    assert pruned(held, frozenset(), lambda kept: None)[0] == {10: 0}


def test_of_two_alike_the_older_stays_unless_it_was_not_recognised_for_long():
    held = driven([(0.3, 0.0, 99), (0.0, 0.0, 99), (0.3, 0.0, 99)], MapSettings(stale_after=2))
    assert standing(held, frozenset())[1:3].tolist() == [1, 2], "the newer was not met again yet"
    held.meet(2, HERE)
    assert standing(held, frozenset())[1:3].tolist() == [2, 2]
    held.meet(1, HERE)
    assert standing(held, frozenset())[1:3].tolist() == [1, 1]
    held.meet(0, HERE)
    held.meet(3, HERE)
    assert standing(held, frozenset())[1:3].tolist() == [1, 1], "both were not"


def test_what_was_never_met_again_goes_and_its_neighbours_are_linked_as_the_robot_measured_it():
    held = driven([(0.3, 0.2, 99)] * 6, MapSettings(forgotten_after=3))
    for index in (3, 6):
        held.meet(index, HERE, link=False)
    measured = {n: composed(inverted(held.pose_of(0)), held.pose_of(n)) for n in (3, 6)}
    for _ in range(3):
        held.meet(0, HERE, link=False)
        held.meet(6, HERE, link=False)
    held.poses[1:3, :2] += 0.1  # the map's error, which is not to be handed on
    heirs, _ = pruned(held, frozenset(), lambda kept: None, wanted=frozenset({5}))
    assert held.ids[: held.count].tolist() == [0, 3, 5, 6], "5 is wanted"
    assert heirs == {}, "none stays where they were: a goal there is not taken to another place"
    seen = {}
    for n in range(held.linked):
        ends = held.ids[held.sources[n]], held.ids[held.targets[n]]
        distance, direction, facing = held.measured[n]
        seen[ends] = distance * math.cos(direction), distance * math.sin(direction), facing
    assert seen[0, 3] == pytest.approx(measured[3], abs=1e-9)
    assert set(seen) == {(0, 3), (3, 5), (5, 6)}
    assert plan(held, 6) is not None


def test_what_cannot_be_handed_on_to_a_near_neighbour_stays():
    held = driven([(0.9, 0.0, 99)] * 4, MapSettings(forgotten_after=3))
    for _ in range(4):
        held.meet(0, HERE, link=False)
        held.meet(4, HERE, link=False)
    assert standing(held, frozenset()).tolist() == [0, 0, 2, 4, 4], "2 is 1.8 m from both"
    pruned(held, frozenset(), lambda kept: None)
    assert held.ids[: held.count].tolist() == [0, 2, 4]


def refusing():
    """Return a map of places in a row, 1 m apart, whose robot is at the last one."""
    return driven([(1.0, 0.0, 99)] * 5, MapSettings())


def test_sightings_that_disagree_move_nobody_however_many():
    held = refusing()
    for n in range(40):
        assert held.refuse([(n % 2 * 3, HERE)], 0.1 * n) is None


def test_sightings_that_agree_are_believed_although_another_place_looks_alike_too():
    held = refusing()
    held.poses[5] = composed(held.pose_of(4), (0.3, 0.0, 0.0))
    found = [held.refuse([(n % 2, HERE), (4, (0.01 * n, 0.0, 0.0))], 0.02 * n) for n in range(6)]
    assert found[0] is None and found[-1] == (4, (0.05, 0.0, 0.0))


def test_a_robot_that_has_not_driven_has_seen_one_thing():
    held = refusing()
    assert [held.refuse([(4, HERE)], 1.0) for _ in range(40)] == [None] * 40
    assert held.refuse([(4, HERE)], 1.06) == (4, HERE)


@pytest.mark.parametrize("offset", [(0.0, 0.0, 0.7), (-0.9, 0.0, 0.0)])
def test_that_the_robot_was_carried_takes_more_sightings_and_makes_no_link(offset):
    held = refusing()
    assert not held.linkable(5, offset)
    found = [held.refuse([(5, offset)], 0.1 * n) for n in range(12)]
    assert found == [None] * 11 + [(5, offset)]


@settings(max_examples=40, deadline=None)
@given(steps, st.integers(0, 40))
def test_what_is_streamed_adds_up_to_the_map(moves, often):
    """A reader that takes only changes, at any pace, has what one has that takes everything."""
    held, told = ExperienceMap(MapSettings()), ChangeLog(0)
    have, links, last = {}, set(), -1
    held.create(0, HERE)
    told.note(held, 1)
    for n, (distance, turn, number) in enumerate(moves, 2):
        held.move(distance, turn, 0.5)
        _ = held.meet(number, HERE) if number < held.count and number != held.current else held.create(n, HERE)
        held.relax()
        told.note(held, n)
        if n % (often + 1) == 0 or n == len(moves) + 1:
            changes = told.since(held, 1, n, last)
            have |= {int(i): tuple(pose) for i, pose in zip(changes.ids, changes.poses, strict=True)}
            links |= {tuple(pair) for pair in changes.links.tolist()}
            last = changes.sequence
    whole = told.since(held, 1, last, -1)
    assert whole.whole and len(have) == held.count
    assert have == {int(i): tuple(pose) for i, pose in zip(whole.ids, whole.poses, strict=True)}
    assert links == {tuple(pair) for pair in whole.links.tolist()}
    nothing = told.since(held, 1, last, last)
    assert not nothing.whole and len(nothing.ids) == len(nothing.links) == 0
