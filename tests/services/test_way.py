"""The way to driving: its steps, the confirmed address, and control as soon as the test is passed."""

import re
from datetime import timedelta

import pytest
from django.core import mail

from accounts import services
from accounts.models import Choice
from queueing import services as queue
from robots.kit.clock import SYSTEM
from robots.models import Lease, Robot
from robots.states import Cycle
from tests.services.turns import drive

pytestmark = [pytest.mark.service, pytest.mark.django_db]

TEST, PAGE = "/robots/mercury/clearance/", "/robots/mercury/"
LINK = re.compile(r"/accounts/confirm-email/[^\s]+/")
NEW = {
    "email": "new@example.org",
    "username": "newcomer",
    "password1": "correct horse 42",
}


@pytest.fixture
def eve(robot, people, client):
    """Somebody who has read the orientation of a robot that is ready."""
    services.load_bank(robot)
    Robot.objects.update(cycle=Cycle.READY)
    Lease.objects.update_or_create(robot=robot, defaults={"epoch": 1, "expires_at": SYSTEM.now() + timedelta(days=99)})
    services.mark_read(people["eve"], robot, SYSTEM.now())
    client.force_login(people["eve"])
    return people["eve"]


def passed(client, robot, user, **more):
    """Send the test with every answer right."""
    attempt = services.begin(user, robot, SYSTEM.now())
    right = {f"q{q.id}": Choice.objects.get(question=q.id, correct=True).pk for q in services.questions(attempt)}
    assert client.post(TEST, {"attempt": attempt.pk, **right, **more})["Location"] == PAGE


@pytest.mark.parametrize(
    ("who", "address", "step"),
    [
        (None, "/accounts/signup/", "Account"),
        (None, "/robots/mercury/orientation/", "Account"),
        ("eve", "/robots/mercury/orientation/", "Orientation"),
        ("ada", "/robots/mercury/orientation/", None),
    ],
)
def test_the_way_to_driving_shows_where_one_stands(robot, people, client, who, address, step):
    if who:
        client.force_login(people[who])
    html = client.get(address).content.decode()
    found = re.search(r'<li aria-current="step">(\w+)</li>', html)
    assert (found and found[1]) == step
    assert ('class="way"' in html) == (step is not None)


def test_the_test_is_the_third_step(eve, client):
    html = client.get(TEST).content.decode()
    assert '<li aria-current="step">Test</li>' in html
    assert html.count('class="done"') == 2


def test_who_passes_and_asks_for_it_takes_control_of_a_free_robot_once(eve, robot, client):
    assert "Send the test and take control" in client.get(TEST).content.decode()
    passed(client, robot, eve, then="take")
    assert " data-take" in client.get(PAGE).content.decode()
    assert " data-take" not in client.get(PAGE).content.decode(), "the page that is opened next"


def test_who_only_passes_or_opens_another_robots_page_takes_nothing(eve, robot, client):
    passed(client, robot, eve)
    assert " data-take" not in client.get(PAGE).content.decode()
    session = client.session
    session["take"] = "another"
    session.save()
    assert " data-take" not in client.get(PAGE).content.decode()
    assert "take" not in client.session


def test_a_robot_for_which_people_wait_is_not_promised(eve, robot, people, client):
    drive(robot, people["ada"], SYSTEM.now())
    queue.join(robot, people["bob"], SYSTEM.now())
    html = client.get(TEST).content.decode()
    assert "take control" not in html
    assert "Send the test" in html


def test_the_link_of_a_mail_confirms_itself_only_in_the_browser_that_signed_up(robot, client):
    client.post("/accounts/signup/", NEW)
    link = LINK.search(mail.outbox[-1].body)[0]
    assert "send_form" in client.get(link).content.decode()
    assert "send_form" not in type(client)().get(link).content.decode(), "a program that looks at links in mails"


def test_the_link_of_one_account_does_not_confirm_itself_where_another_signed_up(robot, client):
    client.post("/accounts/signup/", NEW)
    link = LINK.search(mail.outbox[-1].body)[0]
    other = type(client)()
    other.post("/accounts/signup/", {**NEW, "email": "other@example.org", "username": "somebody"})
    assert "send_form" not in other.get(link).content.decode()
