"""Which place of the map a goal means: one rule for what the portal knows and for the robot's own map."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.kit.contract.capabilities import JobCheck
from robots.kit.contract.errors import BadRequest
from robots.kit.contract.find import function, spec_of
from robots.kit.drivers.irat.brain.messages import Aim
from robots.kit.drivers.irat.brain.mind import Mind
from robots.kit.drivers.irat.brain.places import CLEARED, IN_DOCK, NO_PLACE, MapCleared, check, goal_place
from robots.kit.drivers.irat.composites.decoding import MapShown, with_map
from robots.kit.drivers.irat.packets import HEAD, VERSION
from tests.unit.test_irat_brain import packets as told_of
from tests.unit.test_irat_brain import walk

IDS = np.array([2, 3, 7, 20])
PLACES = np.array([[0.0, 0.0], [0.3, 0.0], [0.6, 0.1], [-1.0, 2.0]])
MAP = MapShown(4, IDS, PLACES)


def why(shown, *wanted):
    try:
        return goal_place(shown, *wanted)
    except BadRequest as error:
        return str(error)


@given(st.floats(-2, 2), st.floats(-1, 3))
def test_a_click_counts_within_ten_centimetres(x, y):
    apart = np.hypot(*(PLACES - (x, y)).T)
    assert why(MAP, 4, x, y) == (IDS[np.argmin(apart)] if apart.min() <= 0.1 else NO_PLACE)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf, 1e308])
def test_a_click_that_is_no_place_is_refused(bad):
    assert why(MAP, 4, bad, 0.0) == why(MAP, 4, 0.0, bad) == NO_PLACE


def test_an_experience_counts_wherever_it_is_by_now_and_one_that_is_gone_by_the_place_of_the_click():
    assert why(MAP, 4, 90.0, 90.0, 7) == 7
    assert why(MAP, 4, 0.31, 0.02, 5) == 3
    for gone in (-1, 0, 21, 2**40):
        assert why(MAP, 4, 90.0, 90.0, gone) == NO_PLACE


def test_another_map_and_an_empty_one_have_no_place():
    assert why(MAP, 5, 0.0, 0.0, 2) == CLEARED
    assert why(MapShown(4), 4, 0.0, 0.0, 2) == NO_PLACE
    with pytest.raises(MapCleared):
        goal_place(MAP, 3, 0.0, 0.0)


def test_only_docking_leads_to_what_is_near_the_dock():
    at_dock = replace(MAP, dock=(0.6, 0.45, 0.42))
    assert why(at_dock, 4, 0.6, 0.1) == why(at_dock, 4, 0.0, 0.0, 7) == IN_DOCK
    assert why(at_dock, 4, 0.3, 0.0) == 3


@pytest.fixture(scope="module")
def walked(tmp_path_factory):
    """A brain whose map has places, and the packets of the map that it told."""
    mind = Mind(tmp_path_factory.mktemp("brain"))
    packets = [(packet.data, packet.key) for packet in told_of(walk(mind, 60))]
    assert len(packets) > 5 and mind.slam.map.count > 5
    return mind, packets


def test_portal_and_robot_judge_alike(walked):
    mind, packets = walked
    held, number = mind.slam.map, mind.slam.map_number
    shown = MapShown()
    for packet in packets:
        shown = with_map(shown, *packet)
    dice = np.random.default_rng(2)
    seen = set()
    for n in range(200):
        x, y = (float(v) for v in held.poses[n % held.count, :2] + dice.uniform(-0.2, 0.2, 2))
        which, experience = (number + (n % 5 == 0), int(dice.integers(0, held.count * 3)))
        own = next(iter(mind.take(Aim(1, which, x, y, experience))))
        if abs(np.hypot(*(held.poses[: held.count, :2] - (x, y)).T).min() - 0.1) < 0.005:
            continue  # the packets tell places in steps of 5 mm
        told = why(shown, which, x, y, experience)
        assert (isinstance(told, str), own.refusal) == (bool(own.refusal), told if own.refusal else "")
        seen.add(own.refusal)
    assert seen == {"", CLEARED, NO_PLACE}


def test_the_spec_names_the_check(walked):
    mind, packets = walked
    number, (x, y) = mind.slam.map_number, mind.slam.map.poses[3, :2]
    own = spec_of("irat").capability(JobCheck)
    judged = function(own.function)
    assert (own.stream, judged) == ("map", check)
    judged("goal", {"map": number, "x": float(x), "y": float(y)}, packets)
    judged("goal", {"map": number, "x": 50.0, "y": 50.0, "experience": int(mind.slam.map.ids[3])}, packets)
    judged("explore", {}, packets)
    with pytest.raises(BadRequest, match=r"No place on the robot's map is within 0\.1 m"):
        judged("goal", {"map": number, "x": 50.0, "y": 50.0}, packets)
    with pytest.raises(MapCleared):
        judged("goal", {"map": number + 1, "x": float(x), "y": float(y)}, packets)


@pytest.mark.parametrize("data", [b"", b"map", HEAD.pack(VERSION, 0, 1, 9, 0), HEAD.pack(VERSION, 0, 1, 2**31, 2**31)])
def test_a_map_that_cannot_be_read_refuses_nobody(data):
    check("goal", {"map": 1, "x": 0.0, "y": 0.0}, [(data, True)])
