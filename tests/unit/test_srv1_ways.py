"""The hall rover's ways: free of cases, exhibits and walls, and short."""

from math import dist

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from robots.kit.contract.errors import OutOfWorkspace
from robots.kit.drivers.srv1.hall import hall
from robots.kit.drivers.srv1.ways import CORNERED, ROOM_M, is_free, length, way

HALL = hall()
PLACES = st.tuples(st.integers(0, 1200), st.integers(0, 800)).map(lambda cm: (cm[0] / 100, cm[1] / 100))
FREE = PLACES.filter(lambda place: HALL.distance(*place) >= ROOM_M)


def test_all_ways_of_the_map_are_free_and_lead_back():
    """The rover may drive along each link of the map, in both directions."""
    named = {node.name: node for node in HALL.nodes}
    for node in HALL.nodes:
        for name in node.to:
            assert is_free(node.at, named[name].at, HALL), f"{node.name} to {name}"
            assert node.name in named[name].to, f"{name} back"


def test_every_node_is_reached_from_every_other():
    """No part of the map is cut off."""
    at = [node.at for node in HALL.nodes]
    for begin in at:
        for end in at:
            assert way(begin, end)[-1] == end


@given(FREE, FREE)
def test_a_way_stays_free_and_is_not_shorter_than_straight(begin, end):
    """Between two places where the rover may stand, each leg of the way is free."""
    try:
        found = way(begin, end)
    except OutOfWorkspace:
        assume(False)
    legs = [begin, *found]
    assert found[-1] == end
    assert all(is_free(a, b, HALL) for a, b in zip(legs, found, strict=False))
    assert length(begin, found) >= dist(begin, end) - 1e-9


@given(PLACES.filter(lambda place: HALL.distance(*place) < ROOM_M), FREE)
def test_a_rover_that_stands_too_near_comes_no_nearer_and_then_has_room(begin, end):
    """It first goes aside; straight to the nearest node it would drive into what it stands beside."""
    try:
        aside, *rest = way(begin, end)
    except OutOfWorkspace as error:
        assert str(error) == CORNERED
        assume(False)
    least, shares = HALL.distance(*begin), [n / 20 for n in range(21)]
    line = [(begin[0] + (aside[0] - begin[0]) * s, begin[1] + (aside[1] - begin[1]) * s) for s in shares]
    assert all(HALL.distance(*place) >= least - 0.01 for place in line)
    assert all(is_free(a, b, HALL) for a, b in zip([aside, *rest], rest, strict=False))


def test_out_of_nearly_every_place_a_way_leads():
    """Only behind a showcase and in a corner behind a vase, where no rover fits, none does."""
    begins = [(x / 10 + 0.05, y / 10 + 0.05) for x in range(120) for y in range(80)]
    near = [begin for begin in begins if 0.12 < HALL.distance(*begin) < ROOM_M]
    assert len(near) > 1000
    cornered = [begin for begin in near if not _leads(begin)]
    assert len(cornered) < 0.04 * len(near), cornered


def _leads(begin):
    try:
        return bool(way(begin, HALL.nodes[0].at))
    except OutOfWorkspace:
        return False


@pytest.mark.parametrize("place", [(3.0, 2.6), (0.1, 4.0), (6.0, 4.0), (-1.0, 2.0), (12.5, 4.0)])
def test_a_place_where_it_cannot_stand_is_refused(place):
    """In a case, at a wall, in an exhibit, outside."""
    with pytest.raises(OutOfWorkspace, match="cannot stand there"):
        way((1.0, 1.0), place)
