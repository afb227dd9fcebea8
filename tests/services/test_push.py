"""Web Push: whoever waits is told of an offer, in their language, by a signed and encrypted message, and once."""

import ssl
from datetime import timedelta

import pytest
from cryptography.exceptions import InvalidTag
from cryptography.hazmat.primitives.asymmetric import ec
from django.conf import settings as real
from django.test import Client

from accounts import push
from accounts.models import PushSubscription
from portal.web import outgoing
from portal.web.push import messages, sending
from portal.web.push.messages import public_key
from queueing import services as queue
from queueing.models import Ticket, TicketState
from queueing.offers import REACHABLE
from queueing.tick import ABSENT_S
from robots.models import Lease, Robot
from tests.security.authority import Authority
from tests.services.push_service import Browser, PushService, answer, read_b64

pytestmark = [pytest.mark.service, pytest.mark.django_db(transaction=True)]
RULES = real.FARHAND
AWAY = timedelta(seconds=RULES["PRESENCE_S"] + 1)
OFFER = timedelta(seconds=RULES["OFFER_S"] + 1)


@pytest.fixture(scope="module")
def authority(tmp_path_factory):
    return Authority(tmp_path_factory.mktemp("authority"))


@pytest.fixture
def service(authority, settings, monkeypatch):
    made = PushService(authority)
    monkeypatch.setattr(outgoing, "tls", lambda: ssl.create_default_context(cafile=str(authority.file)))
    settings.PUSH = settings.PUSH | {"PRIVATE": True}
    yield made
    made.close()


@pytest.fixture
def stage(robot, people, clock):
    Lease.objects.update_or_create(robot=robot, defaults={"epoch": 1, "expires_at": clock.now() + timedelta(days=99)})
    return robot, people, clock


def subscribed(person, browser, **more):
    client = Client()
    client.force_login(person)
    answered = client.post(
        "/me/push/", {"do": "tell", **browser.fields}, headers={"accept": "application/json"}, **more
    )
    assert answered.json() == {"ok": True, "text": ""}
    return client


def offered(stage, name="ada"):
    robot, people, clock = stage
    queue.join(robot, people[name], clock.now())
    queue.tick(clock.now())
    assert Ticket.objects.filter(user=people[name]).latest("pk").state == TicketState.OFFERED


def test_an_offer_is_told_once_signed_encrypted_and_for_as_long_as_it_lasts(stage, service):
    robot, people, clock = stage
    browser = service.browser()
    subscribed(people["ada"], browser)
    offered(stage)
    clock.go(4)
    assert sending.tell_offers(clock.now()) == 1
    assert sending.tell_offers(clock.now()) == 0, "once"
    [heard] = service.heard
    assert heard.line == "POST /push/one HTTP/1.1"
    told = {name: heard.headers[name] for name in ("ttl", "urgency", "topic", "content-encoding")}
    ttl = str(RULES["OFFER_S"] - 4)
    assert told == {"ttl": ttl, "urgency": "high", "topic": f"robot-{robot.pk}", "content-encoding": "aes128gcm"}
    claims, key = heard.claims()
    assert key == public_key()
    assert claims["aud"] == service.url
    assert claims["sub"] == "mailto:farhand@localhost"
    assert 0 < claims["exp"] - clock.now().timestamp() <= 86_400
    message = heard.message(browser)
    assert message["title"] == "It is your turn on Mercury (simulated)"
    assert message["url"] == "/robots/mercury/"
    assert message["until_ms"] == int(Ticket.objects.get().offer_until.timestamp() * 1000)
    assert PushSubscription.objects.get().last_success_at == clock.now()
    assert b"Mercury" not in heard.body
    with pytest.raises(InvalidTag):
        heard.message(Browser(browser.endpoint))


def test_the_browser_of_the_tests_reads_the_example_of_rfc_8291():
    key = int.from_bytes(read_b64("q1dXpw3UpT5VOmu_cf_v6ih07Aems3njxI-JWgLcM94"))
    browser = Browser("", ec.derive_private_key(key, ec.SECP256R1()), read_b64("BTBZMqHH6r4Tts7J_aSIgg"))
    body = (
        "DGv6ra1nlYgDCS1FRnbzlwAAEABBBP4z9KsN6nGRTbVYI_c7VJSPQTBtkgcy27mlmlMoZIIgDll6e3vCYLocInmYWAmS6TlzAC8wEqKK6PBru3jl7A_"
        "yl95bQpu6cVPTpK4Mqgkf1CXztLVBSt2Ks3oZwbuwXPXLWyouBWLVWGNWQexSgSxsj_Qulcy4a-fN"
    )
    assert browser.decrypt(read_b64(body)) == b"When I grow up, I want to be a watermelon"


def test_it_is_in_the_language_of_the_person(stage, service):
    _robot, people, clock = stage
    browser = service.browser()
    type(people["ada"]).objects.update(language="de")
    subscribed(people["ada"], browser)
    offered(stage)
    sending.tell_offers(clock.now())
    message = service.heard[0].message(browser)
    assert message["lang"] == "de"
    assert "Mercury" in message["title"]
    assert not message["title"].startswith("It is")
    assert "{time}" in message["body"]


def test_all_browsers_of_that_person_are_told_and_nobody_elses(stage, service):
    _robot, people, clock = stage
    mine = [service.browser(f"ada{number}") for number in range(3)]
    for browser in mine:
        subscribed(people["ada"], browser)
    subscribed(people["bob"], service.browser("bob"))
    offered(stage)
    assert sending.tell_offers(clock.now()) == 3
    assert {one.line.split()[1] for one in service.heard} == {"/push/ada0", "/push/ada1", "/push/ada2"}


def test_an_offer_that_is_over_or_taken_is_told_to_nobody(stage, service):
    robot, people, clock = stage
    subscribed(people["ada"], service.browser())
    offered(stage)
    queue.accept(robot, people["ada"], clock.now())
    assert sending.tell_offers(clock.now()) == 0
    queue.leave(robot, people["ada"], clock.now())
    Robot.objects.update(cycle="ready")
    offered(stage)
    clock.go(OFFER.total_seconds())
    assert sending.tell_offers(clock.now()) == 0
    assert service.heard == []


@pytest.mark.parametrize("status", [404, 410])
def test_a_subscription_that_is_over_is_forgotten(stage, service, status):
    _robot, people, clock = stage
    subscribed(people["ada"], service.browser())
    service.answers.append(answer(status))
    offered(stage)
    assert sending.tell_offers(clock.now()) == 0
    assert not PushSubscription.objects.exists()


@pytest.mark.parametrize("said", [answer(429, b"Retry-After: 3600"), answer(500), answer(403), b"garbage\r\n\r\n", b"",
                                  answer(307, b"Location: https://127.0.0.1/")])  # fmt: skip
def test_a_push_service_that_fails_is_told_again_at_the_next_offer_and_given_up_in_the_end(stage, service, said):
    _robot, people, clock = stage
    subscribed(people["ada"], service.browser())
    one = PushSubscription.objects.get()
    service.answers.append(said)
    offered(stage)
    assert sending.tell_offers(clock.now()) == 0
    assert PushSubscription.objects.get().failures == 1
    assert len(service.heard) == 1, "no redirect is followed, and nothing is tried again"
    for _ in range(push.MOST_FAILURES - 2):
        push.note_push(one, False, clock.now())
    push.note_push(one, True, clock.now())
    assert PushSubscription.objects.get().failures == 0
    for _ in range(push.MOST_FAILURES):
        push.note_push(one, False, clock.now())
    assert not PushSubscription.objects.exists()


def test_a_push_service_that_hangs_delays_neither_the_queue_nor_other_browsers(stage, service, authority, monkeypatch):
    _robot, people, clock = stage
    monkeypatch.setattr(messages, "LIMITS", outgoing.Limits(each=0.5, all=0.5))
    other = PushService(authority)
    other.hangs.set()
    subscribed(people["ada"], other.browser("hangs"))
    subscribed(people["ada"], service.browser("works"))
    offered(stage)
    assert sending.tell_offers(clock.now()) == 1
    other.close()
    assert [len(one.heard) for one in (service, other)] == [1, 1]
    assert sorted(PushSubscription.objects.values_list("failures", flat=True)) == [0, 1]
    assert Ticket.objects.get().state == TicketState.OFFERED


def test_nothing_is_sent_where_staff_have_switched_it_off(stage, service, settings):
    _robot, people, clock = stage
    subscribed(people["ada"], service.browser())
    settings.PUSH = settings.PUSH | {"ON": False}
    offered(stage)
    assert sending.tell_offers(clock.now()) == 0
    client = Client()
    client.force_login(people["ada"])
    assert "Tell me when it is my turn" not in client.get("/me/").content.decode()
    assert client.get("/me/push/", headers={"accept": "application/json"}).json()["key"] == ""
    refused = client.post(
        "/me/push/", {"do": "tell", **service.browser("b").fields}, headers={"accept": "application/json"}
    )
    assert (refused.status_code, refused.json()["ok"]) == (400, False)


def test_a_person_without_a_page_is_offered_the_robot_only_if_a_browser_tells_them(stage, service):
    robot, people, clock = stage
    subscribed(people["bob"], service.browser())
    for name in ("ada", "bob"):
        queue.join(robot, people[name], clock.now())
    clock.go(AWAY.total_seconds())
    queue.tick(clock.now())
    assert {t.user.username: t.state for t in Ticket.objects.all()} == {"ada": "waiting", "bob": "offered"}


def test_who_does_not_answer_while_away_keeps_the_place_and_others_wait_for_one_offer_only(stage, service):
    robot, people, clock = stage
    subscribed(people["ada"], service.browser())
    queue.join(robot, people["ada"], clock.now())
    clock.go(AWAY.total_seconds())
    queue.join(robot, people["bob"], clock.now())
    queue.tick(clock.now())
    ada = Ticket.objects.get(user=people["ada"])
    assert ada.state == TicketState.OFFERED
    clock.go(OFFER.total_seconds())
    queue.tick(clock.now())
    ada.refresh_from_db()
    assert ada.state == TicketState.WAITING, "kept"
    assert Ticket.objects.get(user=people["bob"]).state == TicketState.OFFERED, "and not offered again while away"
    queue.leave(robot, people["bob"], clock.now())
    queue.note_waiting(people["ada"], clock.now())
    queue.tick(clock.now())
    ada.refresh_from_db()
    assert ada.state == TicketState.OFFERED, "back"
    clock.go(OFFER.total_seconds())
    queue.tick(clock.now())
    ada.refresh_from_db()
    assert ada.state == TicketState.EXPIRED, "there, and not answered: missed, as ever"


@pytest.mark.parametrize(("told", "waits_s"), [(False, ABSENT_S), (True, REACHABLE.total_seconds())])
def test_how_long_the_place_of_a_person_who_is_away_is_kept(stage, service, told, waits_s):
    robot, people, clock = stage
    if told:
        subscribed(people["ada"], service.browser())
    queue.join(robot, people["ada"], clock.now())
    Robot.objects.update(cycle="fault")
    clock.go(waits_s - 1)
    queue.tick(clock.now())
    assert Ticket.objects.get().state == TicketState.WAITING
    clock.go(2)
    queue.tick(clock.now())
    assert Ticket.objects.get().state == TicketState.EXPIRED


def test_after_an_offer_that_passed_the_place_is_kept_for_as_long_as_anybodys(stage, service):
    robot, people, clock = stage
    subscribed(people["ada"], service.browser())
    queue.join(robot, people["ada"], clock.now())
    clock.go(ABSENT_S * 2)
    queue.tick(clock.now())
    assert Ticket.objects.get().state == TicketState.OFFERED
    clock.go(OFFER.total_seconds())
    queue.tick(clock.now())
    clock.go(ABSENT_S - 5)
    queue.tick(clock.now())
    assert Ticket.objects.get().state == TicketState.WAITING
    clock.go(10)
    queue.tick(clock.now())
    assert Ticket.objects.get().state == TicketState.EXPIRED


def test_the_key_is_made_once_and_for_its_owner_alone(tmp_path):
    from portal.folders import kept_secret, new_push_key

    file = tmp_path / "push_key"
    first = kept_secret(file, new_push_key)
    assert kept_secret(file, new_push_key) == first
    assert file.stat().st_mode & 0o777 == 0o600
    assert len(first) == 43
