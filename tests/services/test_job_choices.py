"""A job is requested in people's own words: a place of the map that the robot shows, and labels of values."""

import json
import re
from html import unescape

import numpy as np
import pytest
from django.test import Client

from queueing.models import Job, QueueRobot
from robots.kit.contract.streams import StreamPacket, pack
from robots.kit.drivers.irat.choices import APART_M
from robots.kit.drivers.irat.packets import HEAD, UNIT_M, VERSION

pytestmark = [pytest.mark.service, pytest.mark.django_db]
ADDRESS = "/robots/irat/jobs/"
SPOTS = [(2, 0.0, 0.0), (3, 0.05, 0.05), (7, 1.0, 0.0), (20, -1.0, 2.0)]


@pytest.fixture
def which():
    return "irat"


@pytest.fixture
def shown(robot, monkeypatch):
    """An iRat of which guests ask; what its map's stream keeps is in the list."""
    QueueRobot.objects.filter(robot=robot).update(offers_turns=False, guests_ask=True)
    found = []
    monkeypatch.setattr("robots.services.streams.kept_stream", lambda slug, stream: found)
    return found


def whole_map(number=4):
    ids, x, y = (np.array(column) for column in zip(*SPOTS, strict=True))
    data = HEAD.pack(VERSION, 0, number, len(ids), 0) + ids.astype("<u4").tobytes()
    data += b"".join(np.round(axis / UNIT_M).astype("<i2").tobytes() for axis in (x, y))
    return pack(StreamPacket(0, 1, 0, True, data))


def options(client):
    page = client.get(ADDRESS).content.decode()
    return [(unescape(v), unescape(w)) for v, w in re.findall(r'<option value="([^"]+)"[^>]*>([^<]+)<', page)]


def test_a_place_is_chosen_by_where_it_lies_and_the_map_is_the_present_one(shown):
    shown.append(whole_map())
    guest = Client()
    page = guest.get(ADDRESS).content.decode()
    assert "Place on its map" in page
    assert not re.search(r"16777216|experience</label|>Map<", page), "no numbers that only the robot knows"
    found = options(guest)
    assert [words for _, words in found] == [
        "Top left (0.0 m from the left, 2.0 m from the bottom)",
        "Bottom (1.0 m from the left, 0.0 m from the bottom)",
        "Bottom right (2.0 m from the left, 0.0 m from the bottom)",
    ]  # fmt: skip
    answer = guest.post(ADDRESS, {"kind": "goal", "choice": found[2][0]})
    assert answer.status_code == 302
    assert Job.objects.get().args == {"map": 4, "x": 1.0, "y": 0.0, "experience": 7}
    told = guest.get(answer.url).context["asked"]
    assert told == [("", "1 m right of where its map began"), ("up from where its map began", "0 m")]
    assert APART_M > 0.05, "neighbours are one place"


def test_without_a_map_nothing_can_be_asked_and_it_is_said(shown):
    page = Client().get(ADDRESS).content.decode()
    assert "The robot knows no place yet." in page
    assert "Ask for it" not in page


@pytest.mark.parametrize(
    "choice",
    ["", "{", "[]", "3", "[" * 5000, '{"map": 4}', '{"map": NaN, "x": 0, "y": 0}', '{"map": 9, "x": 0, "y": 0}'],
)
def test_a_choice_that_nobody_offered_is_refused(shown, choice):
    shown.append(whole_map())
    answer = Client().post(ADDRESS, {"kind": "goal", "choice": choice})
    assert (answer.status_code, Job.objects.count()) == (400, 0)
    assert 'role="alert"' in answer.content.decode()


def test_a_choice_of_an_older_map_says_that_the_map_was_cleared(shown):
    shown.append(whole_map())
    value = options(Client())[0][0]
    shown[:] = [whole_map(5)]
    answer = Client().post(ADDRESS, {"kind": "goal", "choice": value})
    assert "The map was cleared" in answer.content.decode()
    assert json.loads(value)["map"] == 4
