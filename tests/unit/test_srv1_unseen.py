"""The report of the rover's journal on the time without contact, whatever the journal contains."""

import json
from dataclasses import replace
from math import cos, pi, sin

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.kit.drivers.srv1.alone import SMALLEST_M, area_of, will_be_inside
from robots.kit.drivers.srv1.answers import Entries, Entry, Event
from robots.kit.drivers.srv1.unseen import GAP_MS, Unseen, packet
from tests.unit.test_srv1_following import REST

NUMBERS = st.integers(0, 2**31)
METRES = st.floats(-1000, 1000)
ENTRIES = st.lists(st.builds(Entry, NUMBERS, NUMBERS, st.sampled_from(Event), NUMBERS, METRES, METRES), max_size=40)


def place(status):
    return status.x, status.y


@given(ENTRIES)
def test_every_journal_makes_a_packet_or_none(entries):
    data = packet(entries, REST, place)
    alone = [entry for entry in entries if entry.event is Event.ALONE]
    assert (data is None) == (not alone)
    if data is None:
        return
    told = json.loads(data)
    assert len(told["ways"]) == len(alone)
    assert [way[0] for way in told["ways"]] == [[round(e.x, 3), round(e.y, 3)] for e in alone]
    assert all(ago >= 0 for ago, *_ in told["events"])
    assert json.loads(packet(entries, REST, None)) == {"ways": [], "events": []}


class Line:
    """A rover with some entries in its journal, three in an answer."""

    def __init__(self, events):
        self.entries = [Entry(number, 100 * number, event, 0) for number, event in enumerate(events, 1)]
        self.asked = 0

    def ask(self, command):
        self.asked += 1
        return Entries(tuple(e for e in self.entries if e.number > command.since)[:3])


def test_only_what_was_missed_is_read():
    line, told = Line([Event.ALONE] * 4 + [Event.ALONE, Event.WAY, Event.WAY, Event.REST]), []
    unseen = Unseen(line, told.append)
    unseen.take_status(replace(REST, journal=4, uptime_ms=1000))
    unseen.catch_up(place)  # of an owner before
    told.clear()
    unseen.take_status(replace(REST, journal=4, uptime_ms=2000))
    unseen.catch_up(place)
    assert told == [], "nothing was missed"
    unseen.take_status(replace(REST, journal=8, uptime_ms=2001 + GAP_MS))
    unseen.take_status(replace(REST, journal=8, uptime_ms=2101 + GAP_MS))
    unseen.catch_up(place)
    assert [event for _, event, *_ in json.loads(told[0])["events"]] == ["alone", "way", "way", "rest"]
    asked = line.asked
    unseen.catch_up(place)
    assert line.asked == asked


@given(
    st.floats(-pi, pi), st.floats(-pi, pi), st.floats(0, 12), st.floats(0, 8), st.floats(-5, 5), st.floats(-5, 5),
    st.floats(0, 3), st.floats(0, 1), st.floats(0, 1),
)  # fmt: skip
def test_every_place_in_the_area_of_a_permit_is_in_the_hall_however_the_axes_lie(h, turn, x, y, ox, oy, spread, u, v):
    status, hall = replace(REST, x=ox, y=oy, heading=h), (12.0, 8.0)
    area = area_of(hall, status, (x, y, h + turn), spread)
    if area is None:
        assert 4.0 - spread < SMALLEST_M
        return
    x0, y0, x1, y1 = area
    at = x0 + u * (x1 - x0), y0 + v * (y1 - y0)
    dx, dy = at[0] - ox, at[1] - oy
    there = x + dx * cos(turn) - dy * sin(turn), y + dx * sin(turn) + dy * cos(turn)
    assert spread - 1e-6 <= there[0] <= 12 - spread + 1e-6
    assert spread - 1e-6 <= there[1] <= 8 - spread + 1e-6
    inside = will_be_inside(area, replace(status, x=at[0], y=at[1]))
    assert inside or min(u, v, 1 - u, 1 - v) < 1e-6


def test_a_rover_of_which_nobody_knows_where_it_is_gets_no_permit():
    assert area_of((12.0, 8.0), REST, (1.0, 1.0, 0.0), 10.0) is None


@pytest.mark.parametrize(("x", "heading", "inside"), [(11.6, 0.0, False), (11.5, pi, True), (11.9, pi, False)])
def test_before_the_edge_it_has_none(x, heading, inside):
    status = replace(REST, x=x, y=4.0, heading=heading, mode="patrol")
    area = area_of((12.0, 8.0), status, (x, 4.0, heading), 0.2)
    assert will_be_inside(area, status) is inside
