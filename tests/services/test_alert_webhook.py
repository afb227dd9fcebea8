"""The webhook of alerts: signed, by TLS, never to a private address, never redirected, and given up in time."""

import contextlib
import json
import socket
import ssl
import threading

import pytest
from allauth.account.models import EmailAddress
from django.core.checks import run_checks
from hypothesis import given
from hypothesis import strategies as st

from portal.web import outgoing
from portal.web.alerts import webhook
from portal.web.alerts.models import AlertChoice, AlertMessage
from tests.security.authority import HOST, Authority, Door
from tests.services.alerts import rounds, stop
from tests.services.alerts import staffed as staffed
from tests.waiting import CEILING_S

pytestmark = [pytest.mark.service, pytest.mark.django_db]
SECRET = "a secret of the tests"


@pytest.fixture(scope="module")
def authority(tmp_path_factory):
    return Authority(tmp_path_factory.mktemp("authority"))


@pytest.fixture
def hook(authority, settings, monkeypatch):
    """A receiver of webhooks by TLS: what it heard, and what it answers, one after the other."""
    heard, answers = [], []

    def serve(line, secure):
        line, data = secure(line)
        while b"\r\n\r\n" not in data or len(data.partition(b"\r\n\r\n")[2]) < _length(data):
            data += line.recv(65536)
        heard.append(data)
        line.sendall(answers.pop(0) if answers else b"HTTP/1.1 204 No Content\r\n\r\n")

    door = Door(authority, serve)
    door.heard, door.answers = heard, answers
    monkeypatch.setattr(outgoing, "tls", lambda: ssl.create_default_context(cafile=str(authority.file)))
    url = f"https://{HOST}:{door.port}/hook?a=1"
    settings.ALERTS = {"AFTER_S": 300, "WEBHOOK": url, "SECRET": SECRET, "PRIVATE": True}
    AlertChoice.objects.create(user_id=EmailAddress.objects.get(email="kim@example.org").user_id, by_mail=False)
    yield door
    door.close()


def _length(data):
    lines = data.partition(b"\r\n\r\n")[0].lower().splitlines()
    return next(int(one.split(b":")[1]) for one in lines if one.startswith(b"content-length"))


def parts(heard):
    head, _, body = heard.partition(b"\r\n\r\n")
    lines = head.decode().split("\r\n")
    return lines[0], dict(line.split(": ", 1) for line in lines[1:]), body


def test_the_webhook_gets_signed_json(robot, clock, hook):
    stop(robot)
    rounds(clock, 5)
    stop(robot, False)
    rounds(clock, 5)
    assert len(hook.heard) == 2
    asked, headers, body = parts(hook.heard[0])
    assert asked == "POST /hook?a=1 HTTP/1.1"
    at = int(headers["Farhand-Signature"].partition(",")[0].removeprefix("t="))
    assert headers["Farhand-Signature"] == webhook.signature(body, at, SECRET)
    told = json.loads(body)
    assert (told["event"], told["robot"], told["kind"], told["until"]) == ("needs_staff", "mercury", "stopped", None)
    assert told["delivery"] == headers["Farhand-Delivery"]
    over = json.loads(parts(hook.heard[1])[2])
    assert (over["event"], over["alert"]) == ("over", told["alert"])
    assert over["until"] is not None


@pytest.mark.parametrize(
    ("answer", "why"),
    [
        (b"HTTP/1.1 500 No\r\nContent-Length: 0\r\n\r\n", "status 500"),
        (b"HTTP/1.1 302 Found\r\nLocation: https://169.254.169.254/\r\n\r\n", "redirect"),
        (b"garbage\r\n\r\n", "cannot be reached"),
        (b"", "cannot be reached"),
    ],
)
def test_a_webhook_that_refuses_or_redirects_gets_it_again_with_the_same_number(robot, clock, hook, answer, why):
    hook.answers.append(answer)
    stop(robot)
    rounds(clock, 2)
    assert why in AlertMessage.objects.get().error
    assert len(hook.heard) == 1, "no redirect is followed"
    rounds(clock, 3)
    assert AlertMessage.objects.get().state == "sent"
    first, second = (parts(one)[1]["Farhand-Delivery"] for one in hook.heard)
    assert first == second


def test_a_webhook_that_never_ends_its_answer_is_cut_off(robot, clock, hook, authority, settings, monkeypatch):
    """It drips a byte now and then, so each step is within its limit; the limit of the whole request ends it."""
    monkeypatch.setattr(webhook, "LIMITS", outgoing.Limits(5.0, 0.5))
    closed = threading.Event()

    def serve(line, secure):
        line, _ = secure(line)
        with contextlib.suppress(OSError):
            while not closed.wait(0.05):
                line.sendall(b"X")
        closed.set()

    door = Door(authority, serve)
    settings.ALERTS = settings.ALERTS | {"WEBHOOK": f"https://{HOST}:{door.port}/"}
    stop(robot)
    rounds(clock, 1.5)
    assert "cannot be reached" in AlertMessage.objects.get().error
    assert closed.wait(CEILING_S)
    door.close()


@pytest.mark.parametrize(
    "address",
    [
        "127.0.0.1",
        "10.0.0.5",
        "192.168.1.1",
        "::1",
        "fd00::1",
        "169.254.169.254",
        "::ffff:10.0.0.1",
        "100.100.100.200",
        "0.0.0.0",
    ],
)
def test_private_addresses_are_refused_whatever_the_name(robot, clock, settings, monkeypatch, address):
    settings.ALERTS = {"AFTER_S": 300, "WEBHOOK": "https://chat.example.org/", "SECRET": SECRET, "PRIVATE": False}
    monkeypatch.setattr(
        socket,
        "getaddrinfo",
        lambda *args, **kwargs: [(0, 0, 0, "", ("93.184.216.34", 443)), (0, 0, 0, "", (address, 443))],
    )
    opened = []
    monkeypatch.setattr(socket, "create_connection", lambda *args, **kwargs: opened.append(args))
    stop(robot)
    rounds(clock, 2)
    assert opened == []
    assert AlertMessage.objects.get(user=None).state == "waiting"


def test_what_was_judged_is_what_is_connected_to(robot, clock, settings, monkeypatch):
    """The name may mean another address a moment later."""
    settings.ALERTS = {"AFTER_S": 300, "WEBHOOK": "https://chat.example.org/", "SECRET": SECRET, "PRIVATE": False}
    found = iter(["93.184.216.34"] + ["127.0.0.1"] * 9)
    monkeypatch.setattr(socket, "getaddrinfo", lambda *args, **kwargs: [(0, 0, 0, "", (next(found), 443))])
    opened = []

    def connect(place, **kwargs):
        opened.append(place[0])
        raise ConnectionRefusedError

    monkeypatch.setattr(socket, "create_connection", connect)
    stop(robot)
    rounds(clock, 1.5)
    assert opened == ["93.184.216.34"]


@pytest.mark.parametrize(
    ("url", "secret"),
    [("http://chat.example.org/", SECRET), ("https://user:pw@chat.example.org/", SECRET), ("https:///x", SECRET),
     ("https://chat.example.org/", "short"), ("https://chat.example.org:99999/", SECRET), ("file:///etc/passwd", SECRET)],
)  # fmt: skip
def test_a_start_with_a_bad_webhook_is_refused(settings, url, secret):
    settings.ALERTS = {"AFTER_S": 300, "WEBHOOK": url, "SECRET": secret, "PRIVATE": False}
    assert [one.id for one in run_checks() if one.id == "portal.E002"] == ["portal.E002"]


@given(st.binary(max_size=200), st.integers(0, 2**40), st.binary(max_size=200))
def test_a_signature_is_of_one_body_and_one_time(body, at, other):
    assert (webhook.signature(body, at, SECRET) == webhook.signature(other, at, SECRET)) is (body == other)
    assert webhook.signature(body, at, SECRET) != webhook.signature(body, at + 1, SECRET)
    assert webhook.signature(body, at, SECRET) != webhook.signature(body, at, SECRET + "x")
