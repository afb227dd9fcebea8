"""Promise 34: signing out, a new password, a ban and a lost clearance close sockets and end the turn within 2 s."""

import json
import socket
import threading
import time
from contextlib import contextmanager
from datetime import timedelta

import pytest
from django.conf import settings as django_settings
from django.contrib.auth.models import Permission
from django.contrib.sessions.models import Session
from django.test import Client

from accounts.models import Clearance
from portal.live import presence
from portal.live.loop import of_loop
from portal.live.sessions import RAN_OUT_S
from queueing import services as queue
from queueing.models import Ticket, TicketState, Turn
from robots import bus
from robots.kit.clock import SYSTEM
from robots.kit.packets import Trace
from robots.models import Robot
from robots.states import Cycle
from tests.conftest import at_length, wait_for
from tests.faults.here import WebHere, closed, heard, line
from tests.faults.witness import Witness

# ruff: noqa: TID251 - its tests are timed
pytestmark = pytest.mark.timed
LIMIT_S = 2.0


class Browser:
    """Somebody signed in, as a browser with a session of its own."""

    def __init__(self, user):
        self.client = Client(HTTP_HOST="localhost")
        self.client.force_login(user)

    @property
    def cookie(self):
        return f"{django_settings.SESSION_COOKIE_NAME}={self.client.cookies[django_settings.SESSION_COOKIE_NAME].value}"

    def open(self, web):
        return line(web, headers={"Cookie": self.cookie})

    def sign_out(self):
        assert self.client.post("/accounts/logout/").status_code == 302


@pytest.fixture
def driving(robot, people, owned):
    """Ada operates the robot."""
    now = SYSTEM.now()
    ticket = queue.join(robot, people["ada"], now)
    Ticket.objects.filter(pk=ticket.pk).update(
        state=TicketState.OFFERED, robot=robot, offer_until=now + timedelta(seconds=30)
    )
    Robot.objects.filter(pk=robot.pk).update(cycle=Cycle.OFFERED)
    return queue.accept(robot, people["ada"], now)


@contextmanager
def soon(more_s=0.0):
    """Judge how long a block takes; what the machine itself stood still meanwhile does not count."""
    witness, begun, took = Witness(), time.monotonic(), []
    yield took
    witness.stop()
    lost = witness.lost(begun, until := time.monotonic())
    took.append(until - begun - lost)
    assert took[0] < LIMIT_S + more_s, (took, lost)


def turn_ended(turn):
    turn.refresh_from_db()
    return turn.ended_at is not None and turn.end_reason


def new_password(browser, user):
    user.set_password("another horse 43")
    user.save()


CAUSES = {
    "signed out": (lambda browser, user: browser.sign_out(), 4401),
    "session expired": (lambda b, u: Session.objects.update(expire_date=SYSTEM.now()), 4401),
    "password": (new_password, 4401),
    "suspended": (lambda b, user: type(user).objects.filter(pk=user.pk).update(is_active=False), 4401),
    "uncleared": (lambda b, u: Clearance.objects.filter(user=u).update(revoked_at=SYSTEM.now()), 4403),
}


@pytest.mark.asvs("7.4.1", "7.4.2", "7.4.3")
@pytest.mark.parametrize("cause", CAUSES)
@pytest.mark.parametrize("with_redis", [True, at_length(False)])
def test_promise_34_the_session_ends_and_with_it_sockets_and_turn(
    web, people, driving, redis_server, proof, cause, with_redis
):
    act, code = CAUSES[cause]
    browser = Browser(people["ada"])
    with browser.open(web) as one, line(web) as watcher:
        assert heard(one, "snapshot")["me"]["can"]["drive"]
        if not with_redis:
            redis_server.stop()
        try:
            with soon(RAN_OUT_S if cause == "session expired" else 0.0) as took:  # the time of day may have been set
                act(browser, people["ada"])
                assert closed(one)[0] == code
                wait_for(lambda: turn_ended(driving), 15, "the end of the turn")
        finally:
            if not with_redis:
                redis_server.start()
        assert driving.grant.__class__.objects.get(pk=driving.grant_id).ended_at is not None
        watcher.send('{"t": "ping", "n": 1}')
        heard(watcher, "pong")
        with browser.open(web) as again:
            assert not heard(again, "snapshot")["me"]["can"]["drive"]
            again.send(json.dumps({"t": "command", "kind": "up", "args": {}, "seq": 9}))
            assert not heard(again, "answer")["ok"]
    web.nothing_left()
    proof.count("sessions ended", 1, 1)
    proof.holds(f"closed and turn ended after {took[0]:.2f} s{'' if with_redis else ', without Redis'}")


def test_the_page_is_told_why(web, people):
    browser = Browser(people["bob"])
    with browser.open(web) as one:
        heard(one, "snapshot")
        browser.sign_out()
        assert closed(one) == (4401, "You have signed out.")


def test_a_sign_out_ends_the_sockets_of_that_session_alone_and_another_one_drives_on(web, people, driving):
    here, phone, second_process = Browser(people["ada"]), Browser(people["ada"]), WebHere()
    bob = Browser(people["bob"])

    def ends_nothing():
        return not of_loop().sessions._ending

    try:
        with here.open(web) as one, phone.open(second_process) as other, bob.open(second_process) as third:
            for each in (one, other, third):
                heard(each, "snapshot")
            wait_for(lambda: driving.sessions.count() == 2, 5, "both sessions of the turn")
            here.sign_out()
            assert closed(one)[0] == 4401
            bob.sign_out()
            assert closed(third)[0] == 4401, "the second process has looked at all sessions since"
            for process in (web, second_process):
                wait_for(lambda process=process: process.ask(ends_nothing), 5, "what ends with the sockets")
            assert not turn_ended(driving)
            other.send('{"t": "ping", "n": 4}')
            assert heard(other, "pong")["n"] == 4
            with soon():
                phone.sign_out()
                assert closed(other)[0] == 4401
                wait_for(lambda: turn_ended(driving), 15, "the end of the turn")
        second_process.nothing_left()
    finally:
        second_process.stop()


def test_a_sign_out_ends_no_turn_of_another_session_that_is_too_slow_to_say_so(web, people, driving, monkeypatch):
    monkeypatch.setattr(presence, "OTHERS_S", 0.0)
    here, phone = Browser(people["ada"]), Browser(people["ada"])
    with here.open(web) as one, phone.open(web) as other:
        for each in (one, other):
            heard(each, "snapshot")
        wait_for(lambda: driving.sessions.count() == 2, 5, "both sessions of the turn")
        here.sign_out()
        assert closed(one)[0] == 4401
        wait_for(lambda: web.ask(lambda: not of_loop().sessions._ending), 5, "what ends with the socket")
        assert not turn_ended(driving)
        phone.sign_out()
        assert closed(other)[0] == 4401
        wait_for(lambda: turn_ended(driving) == "signed out", 5, "the end of the turn")
    assert not driving.sessions.exists()


def test_a_page_in_another_session_that_has_not_reported_for_long_is_asked(web, people, driving, monkeypatch):
    monkeypatch.setattr(presence, "OTHERS_S", 3.0)  # how soon it answers is not what is judged
    here, phone = Browser(people["ada"]), Browser(people["ada"])
    with here.open(web) as one, phone.open(web) as other:
        for each in (one, other):
            heard(each, "snapshot")
        wait_for(lambda: driving.sessions.count() == 2, 5, "both sessions of the turn")
        driving.sessions.update(last_seen=SYSTEM.now() - timedelta(minutes=1))
        here.sign_out()
        assert closed(one)[0] == 4401
        wait_for(lambda: web.ask(lambda: not of_loop().sessions._ending), 10, "what ends with the socket")
        assert not turn_ended(driving)


def test_a_note_of_presence_that_has_begun_keeps_no_turn(web, people, driving, monkeypatch):
    armed, begun, gone, noted = (threading.Event() for _ in range(4))
    seen, disconnect, session_over = queue.note_presence, presence.mark_disconnected, presence.end_session

    def seen_late(*args, **kwargs):
        if armed.is_set():
            begun.set()
            gone.wait(1.0)
        seen(*args, **kwargs)
        if armed.is_set():
            noted.set()

    def disconnect_at_once(*args):
        disconnect(*args)
        gone.set()

    def over_then(*args):
        noted.wait(5)
        session_over(*args)

    monkeypatch.setattr(queue, "note_presence", seen_late)
    monkeypatch.setattr(presence, "mark_disconnected", disconnect_at_once)
    monkeypatch.setattr(presence, "end_session", over_then)
    here = Browser(people["ada"])
    with here.open(web) as one:
        heard(one, "snapshot")
        wait_for(driving.sessions.exists, 5, "the first note")
        armed.set()
        one.send('{"t": "ping", "n": 7}')
        assert begun.wait(10)
        here.sign_out()
        assert closed(one)[0] == 4401
        wait_for(lambda: turn_ended(driving) == "signed out", 5, "the end of the turn")


def test_a_session_whose_page_was_closed_keeps_no_turn(web, people, driving, monkeypatch):
    monkeypatch.setattr(presence, "OTHERS_S", 0.0)
    here, phone = Browser(people["ada"]), Browser(people["ada"])
    with here.open(web) as one:
        with phone.open(web) as other:
            heard(one, "snapshot")
            heard(other, "snapshot")
            wait_for(lambda: driving.sessions.count() == 2, 5, "both sessions of the turn")
        wait_for(lambda: driving.sessions.count() == 1, 5, "the end of one")
        here.sign_out()
        wait_for(lambda: turn_ended(driving) == "signed out", 5, "the end of the turn")


@pytest.mark.asvs("7.4.1", "7.4.2", "7.4.3")
def test_the_wire_trace_ends_with_the_permission(web, people):
    kim = people["kim"]
    with line(web, kim) as one:
        heard(one, "snapshot")
        one.send('{"t": "trace", "on": true}')
        assert heard(one, "answer")["ok"]
        bus.publish_trace("mercury", Trace("in", "00", "hello", 1))
        assert heard(one, "trace")["words"] == "hello"
        with soon():
            kim.user_permissions.remove(Permission.objects.get(codename="change_robot"))
            assert closed(one)[0] == 4403


def test_who_reads_nothing_keeps_nothing(web, people, driving):
    """A socket whose other end has stopped reading cannot be told; it is cut off, and the turn ends all the same."""
    browser = Browser(people["ada"])
    raw = socket.create_connection(("127.0.0.1", web.port))
    raw.sendall(
        (
            f"GET /ws/robots/mercury/ HTTP/1.1\r\nHost: localhost:{web.port}\r\nOrigin: http://localhost:{web.port}\r\n"
            f"Cookie: {browser.cookie}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
            "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n"
        ).encode()
    )
    wait_for(lambda: web.left()["viewers"] == 1, 5, "the viewer")
    for number in range(60):
        bus.publish_picture("mercury", b"\2" + bytes(17) + b"x" * 500_000 + bytes([number]))
        time.sleep(0.01)
    with soon():
        browser.sign_out()
        wait_for(lambda: turn_ended(driving), 15, "the end of the turn")
    wait_for(lambda: not web.left()["viewers"] and not web.left()["sockets"], 5, "the end of the socket")
    raw.close()
    web.nothing_left()


def test_nothing_is_asked_while_nobody_is_signed_in(web, people):
    with line(web) as one:
        heard(one, "snapshot")

        def watching():
            from portal.live.loop import of_loop

            return of_loop().sessions._task is not None and not of_loop().sessions._task.done()

        assert not web.ask(watching)
        with Browser(people["bob"]).open(web) as two:
            heard(two, "snapshot")
            assert web.ask(watching)
        wait_for(lambda: not web.ask(watching), 5, "the end of the checks")
    assert Turn.objects.count() == 0
