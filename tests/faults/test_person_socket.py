"""The person's socket: messages on any page, presence on any page, and nothing that remains after it."""

import contextlib
import json
import time
from datetime import timedelta

import pytest
from websockets.exceptions import ConnectionClosed

from portal.live import person_socket
from queueing import services as queue
from queueing.models import Ticket, TicketState, Turn
from robots import bus
from robots.kit.clock import SYSTEM
from robots.models import Lease
from tests.conftest import wait_for
from tests.faults.here import WebHere, closed, line

# ruff: noqa: TID251 - its tests are timed
pytestmark = pytest.mark.timed


@pytest.fixture
def web(transactional_db, redis_server, robot, people):
    bus.connection().flushall()
    Lease.objects.update_or_create(robot=robot, defaults={"epoch": 5, "expires_at": SYSTEM.now() + timedelta(days=900)})
    made = WebHere()
    yield made
    made.stop()


def me(web, person):
    return line(web, person, "/ws/me/")


def told(one, state, seconds=5):
    """Read until the most urgent place is in that state; return it ('' for none)."""

    def look():
        said = json.loads(one.recv(timeout=seconds))
        if said["t"] != "places":
            return None
        first = said["places"][0] if said["places"] else {"state": ""}
        return first if first["state"] == state else None

    return wait_for(look, seconds, state)


def nothing_left(web):
    def subscribers():
        from portal.live.loop import of_loop

        people = of_loop().people
        return len(people), people._task

    web.nothing_left()
    wait_for(lambda: web.ask(subscribers) == (0, None), 5, "no subscriber")


def test_the_whole_way_from_another_page(web, people, robot):
    with me(web, people["ada"]) as one:
        told(one, "")
        queue.join(robot, people["ada"], SYSTEM.now())  # in another tab
        assert told(one, "waiting")["ahead"] == 0
        queue.tick(SYSTEM.now())
        assert told(one, "offered")["until_ms"] > SYSTEM.now().timestamp() * 1000
        one.send('{"t": "do", "what": "accept", "robot": "mercury"}')
        assert told(one, "operating")["kept_until_ms"] is not None, "until the robot's page is open"
        queue.note_presence(robot, people["ada"], SYSTEM.now())
        wait_for(lambda: told(one, "operating")["kept_until_ms"] is None, 5, "the page that is open")
        one.send('{"t": "do", "what": "leave", "robot": "mercury"}')
        told(one, "")
    assert Turn.objects.get().end_reason == "ended by the operator"
    nothing_left(web)


def test_an_offer_that_is_made_while_the_places_are_read_is_told_at_once(web, people, robot, monkeypatch):
    read, offered = person_socket.standings, []

    def standings(*args):
        found = read(*args)
        if found and not offered:
            offered.append(queue.tick(SYSTEM.now()))
            time.sleep(0.5)  # that the queue changed is heard before the answer is
        return found

    monkeypatch.setattr(person_socket, "standings", standings)
    with me(web, people["ada"]) as one:
        told(one, "")
        queue.join(robot, people["ada"], SYSTEM.now())
        told(one, "offered")


def test_a_missed_offer_is_told_and_dismissed_for_all_pages(web, people, robot):
    with me(web, people["ada"]) as one, me(web, people["ada"]) as other:
        ticket = queue.join(robot, people["ada"], SYSTEM.now())
        queue.tick(SYSTEM.now())
        queue.tick(SYSTEM.now() + timedelta(seconds=31))
        assert told(one, "missed")["ticket"] == ticket.pk
        told(other, "missed")
        one.send(json.dumps({"t": "do", "what": "dismiss", "ticket": ticket.pk}))
        told(one, "")
        told(other, "")


@pytest.mark.asvs("8.2.2")
def test_answers_count_as_presence_for_ones_own_places_only(web, people, robot):
    for name in ("ada", "bob"):
        queue.join(robot, people[name], SYSTEM.now() - timedelta(seconds=80))
    with me(web, people["bob"]) as one:
        told(one, "waiting")
        one.send('{"t": "here"}')
        fresh = SYSTEM.now() - timedelta(seconds=20)
        wait_for(lambda: Ticket.objects.get(user=people["bob"]).last_seen > fresh, 5, "presence")
        assert Ticket.objects.get(user=people["ada"]).last_seen < fresh
        for _ in range(20):
            one.send('{"t": "here"}')
        queue.tick(SYSTEM.now() + timedelta(seconds=15))
        told(one, "offered")
    assert Ticket.objects.get(user=people["ada"]).state == TicketState.WAITING


@pytest.mark.asvs("7.4.1", "7.4.2", "7.4.3")
def test_a_stranger_and_who_signs_out_are_closed(web, people, robot):
    with line(web, path="/ws/me/") as one:
        assert closed(one)[0] == 4401
    with me(web, people["ada"]) as one:
        told(one, "")
        people["ada"].is_active = False
        people["ada"].save()
        with contextlib.suppress(ConnectionClosed):  # it may be closed by now
            one.send('{"t": "look"}')
        assert closed(one)[0] == 4401
    nothing_left(web)


NONSENSE = [
    {"t": "do"}, {"t": "do", "what": "stop", "robot": "mercury"}, {"t": "do", "what": "accept", "robot": "x" * 51},
    {"t": "do", "what": "accept", "robot": "\x00"}, {"t": "do", "what": "dismiss", "ticket": -1},
    {"t": "do", "what": "dismiss", "ticket": 2**63}, {"t": "command", "kind": "move", "seq": 1}, {"t": "here", "n": 1},
]  # fmt: skip


def test_nonsense_is_answered_and_changes_nothing(web, people, robot):
    with me(web, people["ada"]) as one:
        queue.join(robot, people["ada"], SYSTEM.now())
        told(one, "waiting")
        for said in [*NONSENSE, {"t": "do", "what": "accept", "robot": "none"}, {"t": "do", "what": "accept"}]:
            one.send(json.dumps(said))
            answer = wait_for(lambda: (m := json.loads(one.recv(timeout=5)))["t"] == "answer" and m, 5, "an answer")
            assert not answer["ok"], said
            assert answer["text"], said
    assert Ticket.objects.get().state == TicketState.WAITING
    nothing_left(web)


def test_without_redis_it_looks_by_itself(web, people, robot, redis_server):
    with me(web, people["ada"]) as one:
        told(one, "")
        queue.join(robot, people["ada"], SYSTEM.now())
        told(one, "waiting")
        time.sleep(1)  # now it waits for messages
        redis_server.stop()
        try:
            queue.tick(SYSTEM.now())
            told(one, "offered", 10)
        finally:
            redis_server.start()


def test_it_is_told_again_at_the_moments_that_are_announced():
    from portal.live.person_socket import PULSE_S, next_look_s

    def at(left_s):
        return next_look_s({"places": [{"until_ms": left_s * 1000, "kept_until_ms": None, "idle_ms": None}]}, 0)

    assert next_look_s({"places": []}, 0) == PULSE_S
    assert at(300) == PULSE_S
    assert at(65) == pytest.approx(5, abs=0.1)
    assert at(25) == pytest.approx(5, abs=0.1)
    assert at(12) == pytest.approx(2, abs=0.1)
    assert at(5) == pytest.approx(5, abs=0.1)
    assert at(-5) == PULSE_S
