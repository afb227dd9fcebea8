"""A hidden entry: its author reads it with the reason, in the log and on the turn's page; nobody else does."""

import pytest
from django.test import Client

from operatorlog import services as log
from operatorlog.models import Entry, Visibility
from queueing import services as queue
from queueing.models import Turn
from robots.kit.clock import SYSTEM
from robots.states import GrantEnd

pytestmark = [pytest.mark.service, pytest.mark.django_db]
TEXT, REASON = "the watch lies at the upper left", "It gives the place away"
PAGES = (
    "/",
    "/log/",
    "/log/?robot=mercury",
    "/log/?page=1",
    "/robots/mercury/",
    "/status/",
    "/robots/mercury/recordings/",
)


@pytest.fixture
def hidden(robot, roles):
    """An entry of the operator's that a moderator has hidden."""
    turn = Turn.objects.get()
    queue.end_turn(turn, GrantEnd.FINISHED, "", SYSTEM.now())
    entry = log.write(Turn.objects.get(), roles["operator"], TEXT, None, SYSTEM.now())
    log.moderate(entry, roles["log_moderator"], Visibility.HIDDEN, REASON, SYSTEM.now())
    return entry


def signed_in(roles, role):
    client = Client()
    if role != "anonymous":
        client.force_login(roles[role])
    return client


@pytest.mark.parametrize("page", ["/log/", "/log/?robot=mercury", "turn"])
def test_its_author_reads_it_with_the_reason_and_what_to_do(roles, hidden, page):
    address = hidden.turn.get_absolute_url() if page == "turn" else page
    answer = signed_in(roles, "operator").get(address)
    html = answer.content.decode()
    assert TEXT in html
    assert REASON in html
    assert "ask for another look on the page of the turn" in html
    assert "no-store" in answer["Cache-Control"], "no cache may give it to others"


@pytest.mark.asvs("8.2.2")
@pytest.mark.parametrize(
    "role", ["anonymous", "signed_in", "cleared", "log_moderator", "viewer", "robot_staff", "superuser"]
)
def test_no_page_shows_it_or_its_reason_to_anybody_else(roles, hidden, role):
    client = signed_in(roles, role)
    for page in (*PAGES, hidden.turn.get_absolute_url(), f"{hidden.turn.get_absolute_url()}?edit=1"):
        html = client.get(page).content.decode()
        assert TEXT not in html, page
        assert REASON not in html, page


def test_an_account_that_takes_over_the_handle_of_a_deleted_author_does_not_see_it(roles, hidden, django_user_model):
    roles["operator"].delete()
    entry = Entry.objects.get()
    assert entry.author is None
    again = django_user_model.objects.create_user("bob", "new@example.org", "correct horse 42")
    client = Client()
    client.force_login(again)
    for page in (*PAGES, entry.turn.get_absolute_url()):
        assert TEXT not in client.get(page).content.decode(), page


def test_it_is_published_again_for_everybody(roles, hidden):
    log.moderate(hidden, roles["log_moderator"], Visibility.PUBLISHED, "", SYSTEM.now())
    html = Client().get("/log/").content.decode()
    assert TEXT in html
    assert REASON not in html
