"""A robot is held by the end of a command's bound and of the grant, if not sooner, whatever the command declares."""

from dataclasses import replace
from math import inf, nan

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.kit.contract.channels import IN_PLANE, IN_SPACE
from robots.kit.contract.policies import HOLD, Bound, Policies, Range
from robots.kit.contract.session import RobotState
from robots.kit.contract.spec import Spec
from workers.authority.gate import KnownState, inside, why_held

SECONDS = st.floats(0.0, 1e6, exclude_min=True)
NUMBERS = st.floats(allow_nan=True, allow_infinity=True)
RANGES = st.builds(Range, st.sampled_from("xyz"), NUMBERS, NUMBERS)
BOUNDS = st.builds(Bound, SECONDS, st.lists(RANGES, max_size=3).map(tuple), st.none() | NUMBERS, st.none() | NUMBERS)
POLICIES = st.builds(Policies, st.none() | BOUNDS, st.none() | BOUNDS)
KNOWN = st.none() | st.builds(
    KnownState,
    st.dictionaries(st.sampled_from("xyz"), NUMBERS),
    st.lists(NUMBERS, max_size=3).map(tuple),
    st.none() | NUMBERS,
)
TIMES = st.floats(-1e6, 1e6)


@given(POLICIES, TIMES, st.none() | TIMES, TIMES | st.just(inf) | st.just(-inf), KNOWN)
def test_it_is_held_at_the_latest_at_the_end_of_bound_and_grant(policies, now, lost_at, until, known):
    alone = policies.on_link_lost
    ends = [until]
    if lost_at is not None:
        ends.append(lost_at + (alone.seconds if alone else 0.0))
    why = why_held(policies, now, lost_at, until, known)
    if now >= min(ends):
        assert why
    if why == "link":
        assert lost_at is not None


@given(POLICIES, TIMES, TIMES, TIMES, KNOWN)
def test_who_may_go_on_is_known_to_be_inside(policies, now, lost_at, until, known):
    if why_held(policies, now, lost_at, until, known):
        return
    assert policies.on_link_lost is not None
    assert inside(policies.on_link_lost, known)
    last = policies.on_grant_end
    assert last is None or now < until - last.seconds or inside(last, known)


@given(TIMES, st.none() | TIMES, TIMES, KNOWN)
def test_nothing_declared_is_held_at_once(now, lost_at, until, known):
    assert bool(why_held(HOLD, now, lost_at, until, known)) == (lost_at is not None or now >= until)


PLACE = Bound(5.0, (Range("x", 0.0, 2.0),), 0.3)


@pytest.mark.parametrize(
    ("known", "is_inside"),
    [
        (KnownState({"x": 1.0}, (0.1, -0.3)), True),
        (KnownState({"x": 0.0}, (0.3,)), True),
        (KnownState({"x": 2.1}, (0.1,)), False),
        (KnownState({"x": nan}, (0.1,)), False),
        (KnownState({"y": 1.0}, (0.1,)), False),
        (KnownState({"x": 1.0}, ()), False),
        (KnownState({"x": 1.0}, (0.1, -0.31)), False),
        (KnownState({"x": 1.0}, (nan,)), False),
        (None, False),
    ],
)
def test_what_is_not_known_counts_as_outside(known, is_inside):
    assert inside(PLACE, known) is is_inside


@pytest.mark.parametrize(
    ("turn", "is_inside"), [(0.5, True), (-0.5, True), (0.51, False), (nan, False), (inf, False), (None, False)]
)
def test_how_fast_a_body_turns_is_bounded_too(turn, is_inside):
    assert inside(Bound(5.0, turn=0.5), KnownState({}, (9.0,), turn)) is is_inside
    assert not inside(Bound(5.0, turn=0.5), None)


ROVER = Spec("rover", joints=(), pose=IN_PLANE, commands=())
CRANE = Spec("crane", joints=("boom",), pose=IN_SPACE, commands=())


@pytest.mark.parametrize(
    ("spec", "velocities", "twist", "speeds"),
    [
        (ROVER, (), (0.3, -0.4, 0.2), ((0.5,), 0.2)),
        (ROVER, (), (), ((), None)),
        (ROVER, (), (0.3,), ((), None)),
        (ROVER, (0.1,), (0.3, 0.4, 0.2), ((), None)),
        (CRANE, (0.1,), (0.0, 0.0, 0.2, 0.3, 0.0, 0.4), ((0.1, 0.2), 0.5)),
        (CRANE, (0.1,), (), ((0.1,), None)),
        (CRANE, (), (0.0, 0.0, 0.2, 0.3, 0.0, 0.4), ((), None)),
    ],
)
def test_a_state_tells_the_speeds_of_joints_and_body(spec, velocities, twist, speeds):
    state = RobotState(0.0, (), (), True, True, velocities=velocities, twist=twist)
    told, turn = spec.speeds(state)
    assert (told, turn) == (pytest.approx(speeds[0]), speeds[1] if speeds[1] is None else pytest.approx(speeds[1]))
    slow = Bound(5.0, speed=1.0)
    assert inside(slow, KnownState({}, told, turn)) is bool(speeds[0]), "a speed that is not told is outside"


def test_a_motion_that_draws_near_the_end_of_its_grant_has_to_be_inside():
    policies = Policies(on_grant_end=PLACE)
    fast, slow = KnownState({"x": 1.0}, (1.0,)), KnownState({"x": 1.0}, (0.1,))
    assert [why_held(policies, now, None, 60.0, fast) for now in (54.9, 55.0, 60.0)] == ["", "grant", "grant"]
    assert [why_held(policies, now, None, 60.0, slow) for now in (54.9, 55.0, 60.0)] == ["", "", "grant"]


@given(BOUNDS, st.floats(0.0, 1e6))
def test_a_setting_takes_the_place_of_the_seconds_and_0_is_to_be_held(bound, seconds):
    named = Policies(on_link_lost=replace(bound, setting="alone_s"))
    assert named.by({}).on_link_lost is named.on_link_lost
    assert Policies(on_link_lost=bound).by({"alone_s": seconds}).on_link_lost is bound
    found = named.by({"alone_s": seconds}).on_link_lost
    assert (found.seconds if found else 0.0) == seconds
    assert found is None or found.area is bound.area
