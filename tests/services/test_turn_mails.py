"""E-mail of an offer: to who chose it, in their language, once, and while the offer stands, whatever the server does."""

import smtplib
from concurrent.futures import ThreadPoolExecutor
from datetime import timedelta

import pytest
from allauth.account.models import EmailAddress
from django.conf import settings as real
from django.core import mail
from django.test import Client

from accounts.models import Clearance, TurnMail, User
from accounts.turn_mails import HOUR, MOST, MailRefused, choose_mail, mail_choice
from portal.web.push import mailing, tasks
from portal.web.push.mailing import mail_offers
from queueing import services as queue
from queueing.models import Ticket, TicketState, Turn
from queueing.offers import REACHABLE
from queueing.tick import ABSENT_S
from robots.models import Lease, Robot
from tests.services.browsers import signed_in
from tests.services.test_alerts import Server
from tests.waiting import CEILING_S

pytestmark = [pytest.mark.service, pytest.mark.django_db(transaction=True)]
RULES = real.FARHAND
JSON = {"accept": "application/json"}
SITE = "https://robots.example.org"


@pytest.fixture(autouse=True)
def stage(robot, people, clock, settings):
    """Everybody has a confirmed address; ada and eve, who is not cleared, want mails."""
    settings.SITE_ADDRESS = SITE
    Lease.objects.update_or_create(robot=robot, defaults={"epoch": 1, "expires_at": clock.now() + timedelta(days=99)})
    for name in people:
        EmailAddress.objects.create(user=people[name], email=f"{name}@example.org", verified=True, primary=True)
    for name in ("ada", "eve"):
        choose_mail(people[name], True)


@pytest.fixture
def offer(robot, people, clock):
    """Offer the robot, after the last offer was left."""

    def made(name="ada"):
        queue.leave(robot, people[name], clock.now())
        Robot.objects.update(cycle="ready")
        queue.join(robot, people[name], clock.now())
        queue.tick(clock.now())
        ticket = Ticket.objects.filter(user=people[name]).latest("pk")
        assert ticket.state == TicketState.OFFERED
        return ticket

    return made


@pytest.fixture
def served(monkeypatch):
    """Have mails sent by a server of the tests."""

    def by(server):
        monkeypatch.setattr(mailing, "get_connection", lambda timeout: server)
        return server

    return by


class Slow(Server):
    """A mail server that lets each step take so long."""

    def __init__(self, clock, step_s, *fails, at="open"):
        super().__init__(*fails, at=at)
        self.clock, self.step_s, self.asked = clock, step_s, 0

    def _maybe(self, step):
        self.asked += 1
        self.clock.go(self.step_s)
        super()._maybe(step)


def subjects():
    return [one.subject for one in mail.outbox]


def test_an_offer_is_mailed_once_with_the_robots_link_and_until_when_it_stands(offer, clock):
    ticket = offer()
    assert [mail_offers(clock) for _ in range(3)] == [1, 0, 0]
    (sent,) = mail.outbox
    assert sent.to == ["ada@example.org"]
    assert sent.subject == "It is your turn on Mercury (simulated)"
    assert f"{SITE}/robots/mercury/\n" in sent.body
    assert f"before {ticket.offer_until:%-d %B %Y, %H:%M:%S} UTC" in sent.body
    assert f"switch these mails off: {SITE}/me/" in sent.body
    clock.go(60)
    offer()
    assert mail_offers(clock) == 1, "another offer"


def test_it_is_in_the_language_of_the_person(offer, people, clock):
    User.objects.update(language="de")
    offer()
    assert mail_offers(clock) == 1
    assert "Mercury" in subjects()[0]
    assert not subjects()[0].startswith("It is")
    assert "Januar 2026" in mail.outbox[0].body


@pytest.mark.parametrize("why", ["chosen", "unconfirmed", "no_address", "guest", "clearance", "inactive"])
def test_it_goes_to_nobody_else(offer, people, clock, why):
    ada = User.objects.filter(pk=people["ada"].pk)
    ticket = offer()
    assert ticket.mail_due
    {
        "chosen": lambda: choose_mail(people["ada"], False),
        "unconfirmed": lambda: EmailAddress.objects.update(verified=False),
        "no_address": lambda: EmailAddress.objects.all().delete(),
        "guest": lambda: ada.update(guest=True),
        "clearance": lambda: Clearance.objects.update(revoked_at=clock.now()),
        "inactive": lambda: ada.update(is_active=False),
    }[why]()
    assert mail_offers(clock) == 0
    assert mail.outbox == []


def test_without_the_choice_an_offer_has_no_mail(offer, people, clock):
    assert not offer("bob").mail_due
    assert mail_offers(clock) == 0


@pytest.mark.parametrize("end", ["taken", "left", "over", "recalled"])
def test_nothing_is_sent_of_an_offer_that_is_over_before_the_task_runs(offer, robot, people, clock, end):
    offer()
    if end == "taken":
        queue.accept(robot, people["ada"], clock.now())
    elif end == "left":
        queue.leave(robot, people["ada"], clock.now())
    elif end == "recalled":
        Robot.objects.update(cycle="fault")
        queue.tick(clock.now())
    else:
        clock.go(RULES["OFFER_S"])
    assert mail_offers(clock) == 0
    assert mail.outbox == []


def test_a_server_that_is_away_is_asked_again_while_the_offer_stands(offer, robot, people, clock, served):
    server = served(Server(*[ConnectionRefusedError("no")] * 2, smtplib.SMTPConnectError(421, b"busy")))
    offer()
    sent = []
    for _ in range(4):
        sent.append(mail_offers(clock))
        clock.go(2)
    assert sent == [0, 0, 0, 1]
    server.fails = [ConnectionRefusedError("no")] * 99
    ticket = offer()
    while clock.now() < ticket.offer_until:
        assert mail_offers(clock) == 0
        clock.go(2)
    left = len(server.fails)
    assert (mail_offers(clock), len(server.fails)) == (0, left), "not after the offer's end"
    assert Ticket.objects.get(pk=ticket.pk).state == TicketState.OFFERED, "what the queue does is not the mails' affair"
    assert TurnMail.objects.get(user=people["ada"]).sent == 1


def test_a_refused_mail_is_sent_again_and_loses_nothing_and_a_doubtful_one_is_not(offer, robot, people, clock, served):
    refusals = (
        smtplib.SMTPDataError(451, b"later"), smtplib.SMTPRecipientsRefused({"ada@example.org": (450, b"wait")}),
    )  # fmt: skip
    server = served(Server(*refusals, at="send"))
    ticket = offer()
    assert [mail_offers(clock) for _ in range(4)] == [0, 0, 1, 0]
    assert TurnMail.objects.get(user=people["ada"]).sent == 1, "a refused one does not count"
    assert Ticket.objects.get(pk=ticket.pk).state == TicketState.OFFERED
    server.fails = [TimeoutError("no answer")]
    offer()
    assert [mail_offers(clock) for _ in range(3)] == [0, 0, 0], "the server may have it"
    server.fails = [smtplib.SMTPServerDisconnected("gone")]
    offer()
    assert [mail_offers(clock) for _ in range(3)] == [0, 0, 0]
    assert len(mail.outbox) == 1
    assert queue.accept(robot, people["ada"], clock.now())


def test_a_server_that_will_never_take_it_is_asked_once_an_offer(offer, people, clock, served, caplog):
    for fails, at in (
        (smtplib.SMTPRecipientsRefused({"ada@example.org": (550, b"no such user")}), "send"),
        (smtplib.SMTPAuthenticationError(535, b"no"), "open"),
    ):
        server = served(Server(fails, fails, at=at))
        offer()
        assert [mail_offers(clock) for _ in range(3)] == [0, 0, 0]
        assert server.fails == [fails], "asked once"
    assert mail.outbox == []
    assert TurnMail.objects.get(user=people["ada"]).sent == 0
    assert "550" in caplog.text
    assert "ada@example.org" not in caplog.text


def test_a_slow_server_is_not_told_of_an_offer_that_ended_meanwhile(offer, clock, served):
    server = served(Slow(clock, RULES["OFFER_S"] + 1))
    offer()
    assert mail_offers(clock) == 0
    assert (mail.outbox, server.asked) == ([], 1)
    assert mail_offers(clock) == 0
    assert server.asked == 1, "and it is asked no more"
    refused = served(Slow(clock, RULES["OFFER_S"] / 2 + 1, smtplib.SMTPDataError(451, b"later"), at="send"))
    offer()
    assert [mail_offers(clock) for _ in range(3)] == [0, 0, 0], "refused, and over before it could be sent again"
    assert refused.asked == 2


def test_no_turn_and_no_other_task_waits_for_a_server_that_does_not_answer(
    offer, robot, people, clock, served, monkeypatch
):
    assert tasks.mailing()  # made by the process's own clock
    monkeypatch.setattr(tasks, "SYSTEM", clock)

    class Stuck(Server):
        def open(self):
            with ThreadPoolExecutor(1) as other:
                other.submit(tasks.mail.apply).result(CEILING_S)  # the next one, two seconds later
            assert queue.accept(robot, people["ada"], clock.now())
            raise TimeoutError("timed out")

    served(Stuck())
    offer()
    tasks.mail.apply().get()
    assert Turn.objects.get().user == people["ada"]
    assert mail.outbox == []


def test_a_person_gets_so_many_in_an_hour(offer, people, clock):
    for _ in range(MOST + 2):
        offer()
        mail_offers(clock)
        clock.go(60)
    assert len(mail.outbox) == MOST
    clock.go(HOUR.total_seconds())
    offer()
    assert mail_offers(clock) == 1
    clock.step(-timedelta(days=3).total_seconds())
    for _ in range(MOST + 1):
        offer()
        mail_offers(clock)
    assert len(mail.outbox) == 2 * MOST + 1, "a clock that was set back locks nobody out"


@pytest.mark.parametrize(("told", "waits_s"), [(False, ABSENT_S), (True, REACHABLE.total_seconds())])
def test_who_is_told_by_mail_is_offered_the_robot_and_keeps_the_place_also_while_away(
    robot, people, clock, told, waits_s
):
    choose_mail(people["ada"], told)
    queue.join(robot, people["ada"], clock.now())
    clock.go(RULES["PRESENCE_S"] + 1)
    queue.tick(clock.now())
    assert (Ticket.objects.get().state == TicketState.OFFERED) == told
    Ticket.objects.update(state=TicketState.WAITING, offer_until=None)
    Robot.objects.update(cycle="fault")
    clock.go(waits_s - RULES["PRESENCE_S"] - 2)
    queue.tick(clock.now())
    assert Ticket.objects.get().state == TicketState.WAITING
    clock.go(2)
    queue.tick(clock.now())
    assert Ticket.objects.get().state == TicketState.EXPIRED


def test_the_choice_is_off_at_first_and_on_the_persons_page(people):
    bob = signed_in(people["bob"])
    box = 'name="on" aria-describedby="mail-hint"'
    assert f"{box}>" in bob.get("/me/").content.decode()
    assert 'data-mail="off"' in bob.get("/").content.decode()
    for _ in range(2):
        page = bob.post("/me/choices/", {"do": "mail", "on": "on"}, follow=True).content.decode()
        assert "An e-mail, too, tells you that it is your turn." in page
        assert f"{box} checked" in page
    assert 'data-mail="on"' in bob.get("/").content.decode()
    assert TurnMail.objects.filter(user=people["bob"]).count() == 1
    assert bob.post("/me/choices/", {"do": "mail"}, headers=JSON).json()["ok"]
    assert mail_choice(people["bob"]) is False
    assert mail_choice(people["ada"]) is True, "nobody else's"


def test_it_needs_a_confirmed_address_a_session_and_the_forms_token(people):
    EmailAddress.objects.filter(user=people["bob"]).update(verified=False)
    bob = signed_in(people["bob"])
    refused = bob.post("/me/choices/", {"do": "mail", "on": "on"}, headers=JSON)
    assert (refused.status_code, refused.json()["text"]) == (400, "Confirm your e-mail address first.")
    assert 'data-mail=""' in bob.get("/").content.decode()
    assert Client().post("/me/choices/", {"do": "mail", "on": "on"}).status_code == 302
    strict = signed_in(people["kim"], enforce_csrf_checks=True)
    assert strict.post("/me/choices/", {"do": "mail", "on": "on"}).status_code == 403
    assert bob.post("/me/choices/", {"do": "x"}, headers=JSON).status_code == 400
    User.objects.filter(pk=people["kim"].pk).update(guest=True)
    with pytest.raises(MailRefused):
        choose_mail(people["kim"], True)
    assert set(TurnMail.objects.values_list("user__username", flat=True)) == {"ada", "eve"}


def test_changes_are_limited_and_the_choice_goes_with_the_account(people, one_count):
    ada = signed_in(people["ada"])
    answers = [ada.post("/me/choices/", {"do": "mail", "on": "on"}, headers=JSON).status_code for _ in range(31)]
    assert answers == [200] * 30 + [429]
    people["ada"].delete()
    assert not TurnMail.objects.filter(user__username="ada").exists()
