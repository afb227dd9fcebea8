"""`/me/places/`: the bar without a socket, and without scripts."""

import pytest

from queueing import services as queue
from queueing.models import Ticket, TicketState, Turn
from robots.kit.clock import SYSTEM
from robots.models import Robot
from robots.states import Cycle

pytestmark = [pytest.mark.service, pytest.mark.django_db, pytest.mark.timed, pytest.mark.usefixtures("one_count")]
URL = "/me/places/"
JSON = {"Accept": "application/json"}


@pytest.fixture
def ada(client, people, owned):
    client.force_login(people["ada"])
    return client


@pytest.fixture
def offered(ada, people, robot):
    ticket = queue.join(robot, people["ada"], SYSTEM.now())
    queue.tick(SYSTEM.now())
    return ticket


def test_what_it_tells_counts_as_presence(ada, people, robot):
    ticket = queue.join(robot, people["ada"], SYSTEM.now())
    answer = ada.get(URL, headers=JSON)
    assert answer["Cache-Control"].startswith("max-age=0")
    [place] = answer.json()["places"]
    assert (place["state"], place["robot"], place["ahead"]) == ("waiting", robot.slug, 0)
    before = ticket.last_seen
    ticket.refresh_from_db()
    assert ticket.last_seen > before


def test_an_offer_taken_up_by_a_script_keeps_the_turn_while_the_page_opens(ada, offered):
    answer = ada.post(URL, {"do": "accept", "robot": "mercury"}, headers=JSON).json()
    assert (answer["ok"], answer["places"][0]["state"]) == (True, "operating")
    assert answer["places"][0]["kept_until_ms"] < answer["places"][0]["until_ms"]
    assert Turn.objects.get().connected is False


def test_an_offer_taken_up_by_a_form_leads_to_the_robot(ada, offered):
    page = ada.get("/log/").content.decode()
    assert "It is your turn" in page
    answer = ada.post(URL, {"do": "accept", "robot": "mercury", "next": "/log/"})
    assert answer["Location"] == "/robots/mercury/"
    assert Turn.objects.get().ended_at is None
    assert "You operate" in ada.get("/log/").content.decode()


def test_an_offer_taken_up_beside_the_classic_console_stays_there(ada, offered):
    page = ada.get("/classic/mercury/", follow=True)
    at = page.redirect_chain[-1][0]
    assert '<input type="hidden" name="own" value="mercury">' in page.content.decode()
    answer = ada.post(URL, {"do": "accept", "robot": "mercury", "own": "mercury", "next": at})
    assert answer["Location"] == at
    assert "You drive" in ada.get(at).content.decode()


def test_an_offer_that_is_over_says_so_and_leads_back(ada, offered):
    Ticket.objects.update(offer_until=SYSTEM.now())
    answer = ada.post(URL, {"do": "accept", "robot": "mercury", "next": "/log/"}, follow=True)
    assert "The offer is over" in answer.content.decode()
    assert answer.redirect_chain == [("/log/", 302)]


@pytest.mark.asvs("3.7.2")
@pytest.mark.parametrize("where", ["https://elsewhere.example/", "//elsewhere.example", "javascript:alert(1)", ""])
def test_it_leads_to_no_other_site(ada, offered, where):
    assert ada.post(URL, {"do": "leave", "robot": "mercury", "next": where})["Location"] == "/"


def test_a_missed_offer_is_said_on_pages_until_dismissed(ada, offered, robot):
    Ticket.objects.update(offer_until=SYSTEM.now())
    queue.tick(SYSTEM.now())
    assert "You missed your turn" in ada.get("/log/").content.decode()
    ada.post(URL, {"do": "dismiss", "ticket": str(offered.pk)})
    assert "You missed your turn" not in ada.get("/log/").content.decode()


@pytest.mark.parametrize(
    "data",
    [{}, {"do": "accept"}, {"do": "accept", "robot": "none"}, {"do": "x" * 9000},
     {"do": "dismiss", "ticket": "²"}, {"do": "dismiss", "ticket": "9" * 5000}, {"do": "dismiss", "ticket": "-1"},
     {"do": "join", "robot": "mercury' OR 1=1"}],
)  # fmt: skip
def test_nonsense_is_answered_with_a_sentence_and_changes_nothing(ada, offered, data):
    answer = ada.post(URL, data, headers=JSON)
    assert answer.status_code == 200
    assert Ticket.objects.get().state == TicketState.OFFERED
    assert answer.json()["ok"] is (data.get("do") == "dismiss")


def test_what_is_no_text_is_refused_at_the_door(ada, offered):
    assert ada.post(URL, {"do": "accept", "robot": "\x00"}, headers=JSON).status_code == 400
    assert Ticket.objects.get().state == TicketState.OFFERED


def test_who_is_not_signed_in_has_no_bar(client, robot):
    assert client.get(URL, headers=JSON).status_code == 302
    assert "turnbar" not in client.get("/log/").content.decode()


def test_a_robot_that_fell_out_of_order_says_why(ada, offered):
    Robot.objects.update(cycle=Cycle.FAULT, reason="The gripper is cold.")
    answer = ada.post(URL, {"do": "accept", "robot": "mercury"}, headers=JSON).json()
    assert not answer["ok"]
    assert "The gripper is cold" in answer["text"]
