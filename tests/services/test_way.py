"""The way to driving: its steps, the confirmed address, and control as soon as the test is passed."""

import re
from datetime import timedelta

import pytest
from django.core import mail
from django.core.cache import cache

from accounts import services
from accounts.models import Choice
from portal.live.snapshot import of_person, snapshot
from queueing import services as queue
from robots.grants import start_grant
from robots.kit.clock import SYSTEM
from robots.models import Lease, Robot
from robots.services.lockout import lock_out, start_maintenance
from robots.states import Cycle, GrantKind
from tests.services.turns import drive

pytestmark = [pytest.mark.service, pytest.mark.django_db]

TEST, PAGE = "/robots/mercury/clearance/", "/robots/mercury/"
LINK = re.compile(r"/accounts/confirm-email/[^\s]+/")
PATH = re.compile(r"/accounts/confirm-email/\S+")
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
    found = re.search(r'<a href="([^"]+)" aria-current="step">(\w+)</a>', html)
    assert (found and found[2]) == step
    assert found is None or client.get(found[1]).status_code in {200, 302}
    assert ('class="way"' in html) == (step is not None)


def test_the_test_is_the_third_step(eve, client):
    html = client.get(TEST).content.decode()
    assert steps(html) == [
        ("done", "/me/", "Account"), ("done", "/robots/mercury/orientation/", "Orientation"), ("now", TEST, "Test"),
    ]  # fmt: skip


def steps(html):
    """Return the steps of the way that are links: whether done or present, where each leads, and its name."""
    return re.findall(r'<li class="(\w+)"><a href="([^"]+)"[^>]*>(\w+)', html)


def test_the_robots_page_shows_the_way_to_who_has_not_driven_it(robot, people, client):
    client.force_login(people["eve"])
    assert steps(client.get(PAGE).content.decode())[-1] == ("now", "/robots/mercury/orientation/", "Orientation")
    services.mark_read(people["eve"], robot, SYSTEM.now())
    assert steps(client.get(PAGE).content.decode())[-1] == ("now", TEST, "Test")
    client.force_login(people["ada"])
    queue.join(robot, people["ada"], SYSTEM.now())
    shown = steps(client.get(PAGE).content.decode())
    assert [one[0] for one in shown] == ["done", "done", "done", "now"]
    assert shown[-1][1:] == (PAGE, "Drive")


def test_the_snapshot_and_the_classic_console_tell_whether_the_orientation_is_read(robot, people, client):
    eve = people["eve"]
    client.force_login(eve)

    def told():
        now = SYSTEM.now()
        me = snapshot("mercury", eve, now, True)["me"]
        assert of_person("mercury", eve, now)["read"] == me["read"]
        html = client.get("/classic/mercury/", follow=True).content.decode()
        return me["read"], re.search(r'<a class="button primary" href="(/robots/[^"]+)"', html)[1]

    assert told() == (False, "/robots/mercury/orientation/")
    services.mark_read(eve, robot, SYSTEM.now())
    assert told() == (True, TEST)
    assert snapshot("mercury", people["ada"], SYSTEM.now(), True)["me"]["read"], "cleared"


def test_who_has_driven_the_robot_and_strangers_see_no_way_on_its_page(eve, robot, people, client):
    client.logout()
    assert 'class="way"' not in client.get(PAGE).content.decode()
    drive(robot, people["ada"], SYSTEM.now())
    client.force_login(people["ada"])
    assert 'class="way"' not in client.get(PAGE).content.decode()


def test_staff_who_drive_in_a_maintenance_turn_see_no_way(eve, robot, people, client, owned):
    lock_out(robot, people["kim"], "a new belt")
    client.force_login(people["kim"])
    assert 'class="way"' in client.get(PAGE).content.decode()
    start_maintenance(robot, people["kim"])
    assert 'class="way"' not in client.get(PAGE).content.decode()


def test_who_passes_and_asks_for_it_takes_control_of_a_free_robot_once(eve, robot, client):
    assert "Send the test and take control" in client.get(TEST).content.decode()
    passed(client, robot, eve, then="take")
    assert " data-take" in client.get(PAGE).content.decode()
    assert " data-take" not in client.get(PAGE).content.decode(), "the page that is opened next"


def test_a_robot_that_moves_by_itself_is_taken_by_the_same_press(eve, robot, client):
    start_grant(robot, GrantKind.IDLE, SYSTEM.now(), until=SYSTEM.now() + timedelta(minutes=1))
    assert "Send the test and take control" in client.get(TEST).content.decode()


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
    other.post("/accounts/signup/", {**NEW, "email": "other@example.org", "username": "otherone"})
    assert mail.outbox[-1].to == ["other@example.org"]
    assert "send_form" not in other.get(link).content.decode()


DRIVE, SENT = "/robots/mercury/drive/", "/accounts/confirm-email/"


def signed_up(client, wanted=DRIVE):
    """Sign up on the way to a page. Return the path of the mail's link."""
    cache.clear()  # attempts of other tests do not count
    client.post("/accounts/signup/", {**NEW, "next": wanted})
    return PATH.search(mail.outbox[-1].body)[0]


def test_the_mails_link_leads_on_to_the_wanted_robot_in_the_browser_that_signed_up(robot, client):
    answer = client.post(signed_up(client))
    assert answer["Location"] == DRIVE
    assert client.get(DRIVE)["Location"] == "/robots/mercury/orientation/"


def test_so_it_does_in_another_browser_by_way_of_signing_in(robot, client):
    link, other = signed_up(client), type(client)()
    key, _, query = link.partition("?")
    wanted = re.search(r'name="next" value="([^"]+)"', other.get(link).content.decode())[1]
    assert wanted == DRIVE
    answer = other.post(key, {"next": wanted})
    assert answer["Location"] == f"/accounts/login/?{query}"
    login = {"login": NEW["username"], "password": NEW["password1"], "next": wanted}
    assert other.post("/accounts/login/", login)["Location"] == DRIVE
    assert other.get(DRIVE)["Location"] == "/robots/mercury/orientation/"


@pytest.mark.parametrize("wanted", ["https://example.com/", "//example.com", "javascript:alert(1)"])
def test_a_page_elsewhere_is_neither_in_the_mail_nor_led_to(robot, client, wanted):
    link = signed_up(client, wanted)
    assert "?" not in link
    answer = type(client)().post(link, {"next": wanted})
    assert "example.com" not in answer["Location"]
    assert "alert" not in answer["Location"]


def test_who_has_not_confirmed_the_address_is_not_sent_to_sign_up_again(robot, client):
    signed_up(client)
    assert client.get(DRIVE)["Location"] == SENT
    assert "Send the mail again" in client.get(SENT).content.decode()
    assert type(client)().get(DRIVE)["Location"].startswith("/accounts/signup/?next=")
    assert "Send the mail again" not in type(client)().get(SENT).content.decode(), "nobody signed up here"


def test_the_mail_is_sent_again_with_the_same_robot_but_not_at_once(robot, client):
    first = signed_up(client)
    page = client.post("/accounts/send-again/", follow=True)
    assert page.redirect_chain[-1][0] == SENT
    assert "within the last three minutes" in page.content.decode()
    assert len(mail.outbox) == 1
    cache.clear()
    client.post("/accounts/send-again/")
    assert len(mail.outbox) == 2
    assert PATH.search(mail.outbox[-1].body)[0].partition("?")[2] == first.partition("?")[2]
    assert type(client)().post("/accounts/send-again/")["Location"] == "/accounts/login/"
    assert len(mail.outbox) == 2


def test_nothing_tells_that_an_address_is_known(robot, people, client):
    cache.clear()
    client.post("/accounts/signup/", {**NEW, "email": people["ada"].email, "next": DRIVE})
    assert client.get(DRIVE)["Location"] == SENT
    assert "Send the mail again" in client.get(SENT).content.decode()
    sent = len(mail.outbox)
    page = client.post("/accounts/send-again/", follow=True)
    assert "within the last three minutes" in page.content.decode()
    cache.clear()
    assert client.post("/accounts/send-again/")["Location"] == SENT
    assert len(mail.outbox) == sent + 1
    assert PATH.search(mail.outbox[-1].body) is None


def test_who_confirmed_in_another_browser_signs_in_here(robot, client):
    type(client)().post(signed_up(client))
    assert client.post("/accounts/send-again/")["Location"].startswith("/accounts/login/?next="), "no mail is needed"
    assert client.get(DRIVE)["Location"].startswith("/accounts/login/?next=")


@pytest.mark.parametrize("how", ["get", "post"])
def test_a_link_that_was_used_says_that_the_address_is_confirmed_and_leads_on(robot, client, how):
    link = signed_up(client)
    key, _, query = link.partition("?")
    client.post(link)
    page = getattr(client, how)(link, follow=True)
    assert "You have confirmed new@example.org." in page.content.decode()
    assert page.redirect_chain[0][0] == DRIVE
    other = type(client)()
    page = getattr(other, how)(link, follow=True)
    assert "You have confirmed new@example.org." in page.content.decode()
    assert page.redirect_chain[-1][0] == f"/accounts/login/?{query}"
    assert not page.context["user"].is_authenticated, "a used link signs nobody in"
    changed = f"{key[:-3]}x/"
    assert "expired or is invalid" in client.get(changed).content.decode()


def test_who_asks_for_the_mail_again_is_told_why_they_come_to_sign_in(robot, client):
    stranger = type(client)()
    assert "Sign in first." in stranger.post("/accounts/send-again/", follow=True).content.decode()
    type(client)().post(signed_up(client))
    assert "You have confirmed" in client.post("/accounts/send-again/", follow=True).content.decode()
