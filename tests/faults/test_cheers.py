"""Cheers over real sockets: who may, how many count, and what everybody is told; from the attacker's side, too."""

import json
from contextlib import ExitStack

import pytest
from websockets.exceptions import ConnectionClosed

from portal.edge.limits import AddressRate
from queueing import services as queue
from queueing.models import Turn
from queueing.services import end_turn
from robots import bus
from robots.kit.clock import SYSTEM
from robots.kit.packets import Changed
from robots.models import Command, Robot
from robots.states import Cycle, GrantEnd
from tests.conftest import wait_for
from tests.faults.here import closed, heard, line

pytestmark = pytest.mark.timed

CHEER = '{"t": "cheer"}'


@pytest.fixture(autouse=True)
def fresh_limits(monkeypatch):
    monkeypatch.setattr("portal.live.cheers.OF_PERSON", AddressRate(0.2, 3.0))
    monkeypatch.setattr("portal.live.cheers.OF_NETWORK", AddressRate(0.5, 10.0))


@pytest.fixture
def turn(web, robot, people, owned):
    """Ada's turn."""
    queue.join(robot, people["ada"], SYSTEM.now())
    queue.tick(SYSTEM.now())
    return queue.accept(robot, people["ada"], SYSTEM.now())


def cheer(one, said=CHEER):
    """Send a cheer; return whether it counted, and the code of a refusal."""
    one.send(said)
    answer = heard(one, "answer")
    assert answer["to"] == "cheer"
    assert answer["ok"] or answer["text"], "a refusal has a sentence"
    return answer["ok"], answer["code"]


def counter(turn):
    return int(bus.connection().get(bus.cheers_key("mercury", turn.grant_id)) or 0)


def test_everybody_is_told_how_many_cheers_there_are_and_nothing_is_stored_about_who(web, turn, people):
    with line(web) as stranger, line(web, people["bob"]) as bob, line(web, people["ada"]) as ada:
        for one in (stranger, bob, ada):
            assert heard(one, "snapshot")["turn"]["cheers"]
        assert cheer(stranger) == (True, "")
        assert cheer(bob) == (True, "")
        assert cheer(ada) == (False, "drives")
        for one in (stranger, bob, ada):
            while (told := heard(one, "cheers"))["count"] < 2:
                pass
            assert told == {"t": "cheers", "grant": turn.grant_id, "count": 2}
        with line(web) as late:
            assert heard(late, "cheers")["count"] == 2, "who comes later is told, too"
    keys = [key.decode() for key in bus.connection().scan_iter("*cheers*")]
    assert keys == [bus.cheers_key("mercury", turn.grant_id)]
    assert bus.connection().get(keys[0]) == b"2", "a number, and nothing else"
    assert 0 < bus.connection().ttl(keys[0]) <= 3600
    assert not Command.objects.exists()


def test_a_cheer_asks_no_thread_and_no_database(web, turn, monkeypatch):
    def never(*_, **__):
        raise AssertionError("a thread")

    with line(web) as one:
        heard(one, "snapshot")
        monkeypatch.setattr("portal.live.robot_socket.act", never)
        monkeypatch.setattr("portal.live.robot_socket.RobotSocket.orm", never)
        assert cheer(one) == (True, "")


def test_a_flood_of_one_socket_counts_ten_times_and_closes_it(web, turn):
    with line(web, max_queue=None) as flood, line(web) as calm:
        heard(flood, "snapshot")
        heard(calm, "snapshot")
        with pytest.raises(ConnectionClosed):
            for _ in range(2000):
                flood.send(CHEER)
                SYSTEM.sleep(0.001)
        assert closed(flood)[0] == 4429
        told = heard(calm, "cheers")
        assert 10 <= told["count"] <= 13
        calm.send('{"t": "ping", "n": 3}')
        assert heard(calm, "pong")["n"] == 3
    assert counter(turn) <= 15


def test_many_sockets_of_one_network_address_share_one_limit(web, turn):
    with ExitStack() as stack:
        lines = [stack.enter_context(line(web)) for _ in range(15)]
        for one in lines:
            heard(one, "snapshot")
        answers = [cheer(one) for one in lines for _ in range(2)]
    assert 10 <= answers.count((True, "")) <= 14
    assert answers.count((False, "too_often")) >= 16


def test_many_pages_of_one_person_share_one_limit(web, turn, people):
    with line(web, people["bob"]) as one, line(web, people["bob"]) as other:
        heard(one, "snapshot")
        heard(other, "snapshot")
        answers = [cheer(page) for page in (one, other) * 4]
    assert answers.count((True, "")) <= 4
    assert answers.count((False, "too_often")) >= 4


def test_messages_come_at_most_once_a_second_however_many_cheer(web, turn, monkeypatch, stopwatch):
    monkeypatch.setattr("portal.live.cheers.OF_NETWORK", AddressRate(1e6, 1e6))
    with line(web) as watcher, line(web) as one:
        heard(watcher, "snapshot")
        heard(one, "snapshot")
        begin, counts = stopwatch.monotonic(), []
        for _ in range(60):
            cheer(one)
            SYSTEM.sleep(0.1)
        wait_for(lambda: counter(turn) == 60, 10, "all cheers")
        while not counts or counts[-1] < 60:
            counts.append(heard(watcher, "cheers")["count"])
        assert len(counts) <= stopwatch.monotonic() - begin
        assert counts == sorted(set(counts))


def test_while_nobody_drives_nobody_is_cheered_and_the_next_turn_begins_at_none(web, turn, robot, people):
    with line(web) as one:
        heard(one, "snapshot")
        assert cheer(one) == (True, "")
        heard(one, "cheers")
        end_turn(Turn.objects.get(ended_at=None), GrantEnd.TIME_UP, "time is up", SYSTEM.now())
        while heard(one, "snapshot")["turn"] is not None:
            pass
        assert cheer(one) == (False, "not_driven")
        Robot.objects.update(cycle=Cycle.READY)  # as its owner does
        queue.join(robot, people["bob"], SYSTEM.now())
        queue.tick(SYSTEM.now())
        after = queue.accept(robot, people["bob"], SYSTEM.now())
        while (heard(one, "snapshot")["turn"] or {}).get("grant") != after.grant_id:
            pass
        assert cheer(one) == (True, "")
        assert heard(one, "cheers") == {"t": "cheers", "grant": after.grant_id, "count": 1}


def test_a_robot_that_has_it_switched_off_takes_none_also_while_pages_are_open(web, turn):
    with line(web) as one:
        heard(one, "snapshot")
        Robot.objects.update(cheers=False)
        bus.publish("mercury", Changed("robot"))
        while heard(one, "snapshot")["turn"]["cheers"]:
            pass
        assert cheer(one) == (False, "not_driven")
    with line(web) as late:
        heard(late, "snapshot")
        assert cheer(late) == (False, "not_driven")
    assert counter(turn) == 0


@pytest.mark.parametrize("more", [{"count": 5}, {"robot": "irat"}, {"seq": 1}, {"text": "x" * 5000}])
def test_unknown_fields_of_a_cheer_are_refused(web, turn, more):
    with line(web) as one:
        heard(one, "snapshot")
        assert cheer(one, json.dumps({"t": "cheer", **more})) == (False, "bad_request")
        assert web.ask(lambda: _hub().cheers("mercury").new) == 0


def _hub():
    from portal.live.loop import of_loop

    return of_loop().hub
