"""The hall rover's ways: free of cases, exhibits and walls, and short."""

from math import dist

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from robots.contract.errors import OutOfWorkspace
from robots.description import load
from robots.drivers.srv1.ways import ROOM_M, is_free, length, room, way

HALL = load("srv1")["hall"]
PLACES = st.tuples(st.floats(0, HALL["width"]), st.floats(0, HALL["depth"]))


def test_all_ways_of_the_map_are_free_and_lead_back():
    """The rover may drive along each link of the map, in both directions."""
    at = {node["name"]: tuple(node["at"]) for node in HALL["node"]}
    for node in HALL["node"]:
        for name in node["to"]:
            assert is_free(at[node["name"]], at[name], HALL), f"{node['name']} to {name}"
            assert node["name"] in next(n for n in HALL["node"] if n["name"] == name)["to"], f"{name} back"


def test_every_node_is_reached_from_every_other():
    """No part of the map is cut off."""
    at = [tuple(node["at"]) for node in HALL["node"]]
    for begin in at:
        for end in at:
            assert way(begin, end)[-1] == end


@given(PLACES, PLACES)
def test_a_way_stays_free_and_is_not_shorter_than_straight(begin, end):
    """Between two places where the rover may stand, each leg of the way is free."""
    assume(room(begin, HALL) >= ROOM_M and room(end, HALL) >= ROOM_M)
    try:
        found = way(begin, end)
    except OutOfWorkspace:
        assume(False)
    legs = [begin, *found]
    assert found[-1] == end
    assert all(is_free(a, b, HALL) for a, b in zip(legs, found, strict=False)) or not any(
        is_free(begin, tuple(node["at"]), HALL) for node in HALL["node"]
    )
    assert length(begin, found) >= dist(begin, end) - 1e-9


@pytest.mark.parametrize("place", [(3.0, 2.6), (0.1, 4.0), (6.0, 4.0), (-1.0, 2.0), (12.5, 4.0)])
def test_a_place_where_it_cannot_stand_is_refused(place):
    """In a case, at a wall, in an exhibit, outside."""
    with pytest.raises(OutOfWorkspace, match="cannot stand there"):
        way((1.0, 1.0), place)


def test_room_is_measured_to_the_nearest_thing():
    """To a wall, to a case's side and corner, to a round exhibit; below 0 inside."""
    assert room((0.5, 4.0), HALL) == pytest.approx(0.5)
    assert room((3.0, 2.0), HALL) == pytest.approx(0.2)
    assert room((3.8 + 0.3, 3.0 + 0.4), HALL) == pytest.approx(0.5)
    assert room((6.0, 4.8), HALL) == pytest.approx(0.25)
    assert room((3.0, 2.6), HALL) < 0
