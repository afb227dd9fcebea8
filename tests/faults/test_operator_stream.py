"""The operator's stream is opened with a one-time code and ends with the turn; without a valid code a page views."""

import json
import threading
from contextlib import contextmanager

import pytest
from django.conf import settings
from django.test import Client
from websockets.exceptions import ConnectionClosed

from portal.live import codes
from portal.live.access import Access, OperatorAccess
from queueing.models import Turn
from queueing.services import end_turn
from robots import bus, services
from robots.kit.clock import SYSTEM
from robots.kit.packets import picture_packet
from robots.models import Grant
from robots.states import GrantEnd, GrantKind
from tests.conftest import wait_for
from tests.faults.here import WebHere, closed, heard, line
from tests.services.conftest import ROLES, roles  # noqa: F401

pytestmark = pytest.mark.timed

OVER = 4410


class Browser:
    """Somebody with a session, or a stranger."""

    def __init__(self, user=None):
        self.client = Client(HTTP_HOST="localhost")
        if user is not None and user.is_authenticated:
            self.client.force_login(user)

    @property
    def headers(self):
        found = self.client.cookies.get(settings.SESSION_COOKIE_NAME)
        return {"Cookie": f"{settings.SESSION_COOKIE_NAME}={found.value}"} if found else {}

    def ask(self, slug="mercury"):
        return self.client.post(f"/robots/{slug}/stream-code/")

    def told(self):
        """Return what it is told that asks for a code; it asks again where Redis did not answer in time."""
        for _ in range(5):
            if (answer := self.ask()).status_code != 503:
                break
        return answer.json()

    def code(self):
        return self.told()["code"]

    @contextmanager
    def opened(self, web):
        """Give a stream of its own and the first snapshot; with another code where Redis did not answer in time."""
        for _ in range(5):
            with self.stream(web, self.code()) as one:
                try:
                    first = heard(one, "snapshot")
                except ConnectionClosed as end:
                    if end.rcvd is None or end.rcvd.reason != codes.UNKNOWN:
                        raise
                    continue
                yield one, first
                return
        raise AssertionError("a stream: not within five attempts, because Redis did not answer in time")

    def stream(self, web, code, slug="mercury"):
        return line(web, path=f"/ws/operators/{slug}/", headers=self.headers, subprotocols=["farhand.operator", code])

    def watch(self, web):
        return line(web, headers=self.headers)


@pytest.fixture
def drives(web, robot, people, owned):
    """Ada's browser; she drives."""
    from queueing import services as queue

    queue.join(robot, people["ada"], SYSTEM.now())
    queue.tick(SYSTEM.now())
    queue.accept(robot, people["ada"], SYSTEM.now())
    return Browser(people["ada"])


def turn():
    return Turn.objects.get(ended_at=None)


def end(silently=False, monkeypatch=None):
    if silently:
        monkeypatch.setattr(bus, "publish", lambda *_: True)
    end_turn(turn(), GrantEnd.TIME_UP, "time is up", SYSTEM.now())


def refused(one):
    with one:
        code, reason = closed(one)
    assert code == OVER
    return reason


def judged(attempt):
    """Return the reasons that an attempt ends with; it is made anew where Redis did not answer in time."""
    for _ in range(5):
        if codes.UNKNOWN not in (reasons := attempt()):
            break
    return reasons


@pytest.mark.asvs("4.4.4")
def test_the_stream_is_opened_with_a_code_and_carries_pictures_commands_and_presence(web, drives):
    with drives.watch(web) as public, drives.opened(web) as (own, first):
        assert first["me"]["can"]["drive"]
        while not first["link"]:  # else the picture may come before it is listened to
            first = heard(own, "snapshot")
        bus.publish_picture("mercury", picture_packet(7, 1, 0, (), b"jpeg"))
        assert wait_for(lambda: isinstance(data := own.recv(timeout=5), bytes) and data[0] == 2, 5, "the picture")
        own.send(json.dumps({"t": "command", "kind": "up", "seq": 1}))
        assert heard(own, "answer")["ok"]
        public.close()
        wait_for(lambda: web.left()["sockets"] == 1, 5, "the end of the public one")
        assert turn().connected, "the page goes on over its own stream"
    wait_for(lambda: not turn().connected, 5, "the operator is away")
    web.nothing_left()


def test_each_connection_needs_another_code(web, drives):
    first, second = drives.code(), drives.code()
    assert first != second
    assert len(first) == 43
    given = [first, second]

    def twice():
        code = given.pop(0) if given else drives.code()
        with drives.stream(web, code) as own:
            try:
                heard(own, "snapshot")
            except ConnectionClosed as end:
                return [end.rcvd.reason]
        return ["opened", refused(drives.stream(web, code))]

    for _ in range(2):
        assert judged(twice) == ["opened", codes.SPENT]


def test_of_two_who_use_a_code_at_once_one_gets_in(web, drives):
    other = WebHere()

    def both():
        code, found = drives.code(), []

        def open_one(where):
            with drives.stream(where, code) as one:
                try:
                    found.append(heard(one, "snapshot")["t"])
                except ConnectionClosed as end:
                    found.append(end.rcvd.reason)

        threads = [threading.Thread(target=open_one, args=(where,)) for where in (web, other)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(30)
        assert not any(thread.is_alive() for thread in threads), "an answer to each: not within 30 s"
        return sorted(found)

    try:
        assert judged(both) == sorted(["snapshot", codes.SPENT])
    finally:
        other.stop()


@pytest.mark.asvs("8.2.2", "8.3.1")
def test_another_person_has_nothing_of_a_code_and_it_is_spent(web, drives, people):
    for thief in (Browser(people["bob"]), Browser(people["kim"]), Browser()):

        def stolen(thief=thief):
            code = drives.code()
            return [refused(thief.stream(web, code)), refused(drives.stream(web, code))]

        assert judged(stolen) == [codes.ANOTHERS, codes.SPENT]
        with thief.watch(web) as public:
            assert not heard(public, "snapshot")["me"]["can"]["drive"]
    with drives.opened(web):
        pass


def test_a_code_that_nobody_gave_opens_nothing(web, drives):
    for code in ("x" * 43, "x", "farhand.operator", bus.code_key("x").replace(":", "-")):
        assert judged(lambda code=code: [refused(drives.stream(web, code))]) == [codes.SPENT]
    assert refused(line(web, path="/ws/operators/mercury/", headers=drives.headers)) == codes.SPENT
    assert judged(lambda: [refused(drives.stream(web, drives.code(), "none"))]) == [codes.ELSEWHERE]
    web.nothing_left()


def test_a_code_lives_half_a_minute_and_redis_knows_its_digest_alone(web, drives):
    code, store = drives.code(), bus.connection()
    found = store.keys(bus.code_key("*"))  # more than one where Redis answered too late
    assert found
    for kept in found:
        assert code.encode() not in kept + store.get(kept)
        assert 0 < store.ttl(kept) <= 30
        store.pexpire(kept, 1)
    wait_for(lambda: not store.exists(*found), 5, "its end")
    assert judged(lambda: [refused(drives.stream(web, code))]) == [codes.SPENT]


@pytest.mark.asvs("8.3.1")
@pytest.mark.parametrize("silently", [False, True])
def test_the_stream_ends_with_the_turn(web, drives, monkeypatch, silently):
    unused = [drives.code() for _ in range(5)]
    with drives.opened(web) as (own, first), drives.watch(web) as public:
        for said in (first, heard(public, "snapshot")):
            assert said["me"]["can"]["drive"]
        if not silently:  # the event alone ends it, not the look that a busy machine may take first
            monkeypatch.setattr(OperatorAccess, "judge", Access.judge)
        end(silently, monkeypatch)
        if not silently:
            wait_for(lambda: not heard(own, "snapshot")["me"]["can"]["drive"], 10, "the page is told first")
        assert closed(own, 2) == (OVER, codes.TURN_OVER)
        public.send('{"t": "ping", "n": 1}')
        heard(public, "pong")
    assert judged(lambda: [refused(drives.stream(web, unused.pop()))]) == [codes.TURN_OVER]
    assert not drives.code()


def test_a_code_of_the_turn_before_does_not_open_the_next_ones_stream(web, drives, robot, people):
    unused = [drives.code() for _ in range(5)]
    end()
    now = SYSTEM.now()
    services.start_grant(robot, GrantKind.STAFF, now, people["ada"])
    assert judged(lambda: [refused(drives.stream(web, unused.pop()))]) == [codes.TURN_OVER]


def test_who_reads_nothing_is_given_nothing_after_the_turn(web, drives):
    with drives.opened(web):
        wait_for(lambda: web.left()["viewers"] == 1, 5, "the viewer")
        end()
        wait_for(lambda: web.left()["viewers"] == 0, 2, "no viewer, though nothing was read")


@pytest.mark.asvs("7.4.1")
def test_signing_out_ends_stream_and_turn(web, drives):
    begun = turn()
    with drives.opened(web) as (own, _):
        drives.client.post("/accounts/logout/")
        assert closed(own)[0] == 4401
    wait_for(lambda: Turn.objects.get(pk=begun.pk).ended_at, 5, "the end of the turn")


def test_who_gets_a_code(web, robot, roles):  # noqa: F811
    found = {}
    for role in ROLES:
        answer = Browser(roles[role]).told()
        found[role] = bool(answer["code"])
        assert found[role] or answer["text"] == "It is not your turn on this robot."
    assert found == {role: role == "operator" for role in ROLES}
    assert len(bus.connection().keys(bus.code_key("*"))) == 1
    assert Browser().client.get("/robots/mercury/stream-code/").status_code == 405
    assert Browser(roles["operator"]).ask("none").status_code == 404


def test_nobody_gets_a_code_of_a_grant_without_a_holder(web, robot, people, owned):
    services.start_grant(robot, GrantKind.IDLE, SYSTEM.now())
    assert not Browser().code()


def test_another_site_gets_no_code(web, drives, people):
    strict = Client(HTTP_HOST="localhost", enforce_csrf_checks=True)
    strict.force_login(people["ada"])
    assert strict.post("/robots/mercury/stream-code/").status_code == 403
    assert not bus.connection().keys(bus.code_key("*"))


def test_codes_are_given_so_often_a_minute(web, drives):
    assert {drives.ask().status_code for _ in range(60)} == {200}
    assert drives.ask().status_code == 429


@pytest.mark.asvs("15.2.2")
def test_a_crowd_takes_no_place_from_the_operator(web, drives, monkeypatch):
    """Strangers have filled the robot and the operator's network address has as many sockets as it may."""
    monkeypatch.setitem(settings.LIMITS, "VIEWERS", 1)
    bounded = web.server.config.loaded_app
    while not hasattr(bounded, "_sockets"):
        bounded = bounded.app
    with line(web) as stranger:
        heard(stranger, "snapshot")
        with line(web) as more:
            assert closed(more)[0] == 4503
        monkeypatch.setattr(bounded._sockets, "most", 1)
        with pytest.raises(Exception, match="429"):
            drives.watch(web)
        with drives.opened(web) as (_, first):
            assert first["me"]["can"]["drive"]
            monkeypatch.setattr(bounded._operators, "most", 1)
            with pytest.raises(Exception, match="429"):
                drives.stream(web, drives.code())


def test_without_redis_no_code_is_given_and_the_public_view_drives_on(web, drives, redis_server):
    code = drives.code()
    with drives.watch(web) as public:
        heard(public, "snapshot")
        redis_server.stop()
        try:
            assert drives.ask().status_code == 503
            assert refused(drives.stream(web, code)) == codes.UNKNOWN
            public.send(json.dumps({"t": "command", "kind": "up", "seq": 1}))
            assert heard(public, "answer")["ok"]
        finally:
            redis_server.start()


def test_a_stream_of_staff_ends_with_their_grant_too(web, robot, people, owned):
    grant = services.start_grant(robot, GrantKind.STAFF, SYSTEM.now(), people["kim"])
    kim = Browser(people["kim"])
    with kim.opened(web) as (own, _):
        services.end_grant(Grant.objects.get(pk=grant.pk), GrantEnd.FINISHED, "done", SYSTEM.now())
        assert closed(own, 2) == (OVER, codes.TURN_OVER)
