"""The portal was away while machine and clock went on: nobody loses a place or a turn because of that time."""

from datetime import timedelta

import pytest
from django.conf import settings
from django.db import OperationalError

from portal.run import uptime
from queueing import services as queue
from queueing.models import Queue, Ticket, Turn
from queueing.steps import carry
from queueing.tasks import queue_tick
from queueing.tick import ABSENT_S
from robots import bus
from robots.bus import web_uptime
from robots.models import Lease
from tests.services.clock_steps import HOUR

pytestmark = [pytest.mark.service, pytest.mark.django_db, pytest.mark.timed]
RULES = settings.FARHAND


class Portal:
    """Web process, scheduler, database and Redis, of which some are away."""

    def __init__(self, clock, looks):
        self.clock, self.looks = clock, looks
        self.web = self.scheduler = True

    def goes(self, seconds, *present, robot=None):
        """Let so many seconds pass; `present`: whose pages report meanwhile."""
        each = 2 if seconds <= 30 else 10
        for _ in range(round(seconds / each)):
            now = self.clock.go(each)
            Lease.objects.update(expires_at=now + timedelta(seconds=30))
            if self.web:
                uptime.tell()
                for person in present:
                    queue.note_waiting(person, now)
                    queue.note_presence(robot, person, now, session="s")
            else:
                self.forgets()
            if self.scheduler:
                queue_tick()

    def forgets(self):
        """Let Redis forget the web process, as it does after some seconds by its own clock."""
        web_uptime.forget()

    def off(self, seconds):
        """Be away as a whole."""
        self.forgets()
        self.clock.go(seconds)


@pytest.fixture
def portal(clock, trusted, redis_server, monkeypatch):
    monkeypatch.setattr("queueing.tasks.wall_clock", lambda: trusted)
    monkeypatch.setattr("portal.run.uptime.SYSTEM", clock)
    web_uptime.forget()
    yield Portal(clock, trusted)
    web_uptime.forget()


@pytest.fixture
def waiting(robot, people, owned, portal):
    """Ada and bob wait, in this order, with their pages open; the robot is not offered."""
    Queue.objects.update(paused=True)
    for name in ("ada", "bob"):
        queue.join(robot, people[name], portal.clock.now())
        portal.goes(2)
    portal.goes(20, people["ada"], people["bob"], robot=robot)
    return robot


def states():
    return list(Ticket.objects.order_by("pk").values_list("state", "end_reason"))


WAITS = [("waiting", "")] * 2


def test_nobody_loses_a_place_because_the_whole_portal_was_off(waiting, people, portal):
    portal.off(ABSENT_S)
    queue_tick()  # before any web process
    assert states() == WAITS
    portal.goes(10)  # pages are not back yet
    assert states() == WAITS
    portal.goes(ABSENT_S, people["ada"], robot=waiting)
    assert states() == [("waiting", ""), ("expired", "was away too long")], "an absence counts as ever from then on"


def test_nobody_loses_a_place_because_no_web_process_ran(waiting, people, portal):
    portal.web = False
    portal.goes(2 * ABSENT_S)
    assert states() == WAITS
    portal.web = True
    portal.goes(ABSENT_S - 10, people["ada"], robot=waiting)
    assert states() == WAITS
    portal.goes(20, people["ada"], robot=waiting)
    assert [state for state, _ in states()] == ["waiting", "expired"]


def test_nobody_loses_a_place_because_the_scheduler_alone_was_off_but_who_went_away_does(waiting, people, portal):
    portal.scheduler = False
    portal.goes(ABSENT_S + 10, people["ada"], robot=waiting)
    portal.scheduler = True
    portal.goes(2, people["ada"], robot=waiting)
    assert [state for state, _ in states()] == ["waiting", "expired"]


def test_nobody_loses_a_place_because_the_database_was_away(waiting, portal, monkeypatch):
    with monkeypatch.context() as away:
        away.setattr("portal.run.uptime.connection.cursor", lambda: (_ for _ in ()).throw(OperationalError("away")))
        web_uptime.forget()  # Redis's own clock
        uptime.tell()
        assert web_uptime.up_since(portal.clock.now()) == portal.clock.now(), "a page could not be noted"
        portal.clock.go(ABSENT_S)
    queue_tick()  # the first one that the database answers
    assert states() == WAITS
    portal.goes(30)
    assert states() == WAITS


def test_nobody_loses_a_place_because_redis_was_away(waiting, portal, monkeypatch):
    portal.clock.go(ABSENT_S)  # nothing is sent to the worker meanwhile
    with monkeypatch.context() as gone:
        gone.setattr("robots.bus.store.connection", lambda: (_ for _ in ()).throw(OSError("away")))
        uptime.tell()
        queue_tick()
        assert states() == WAITS
    portal.forgets()  # a Redis that began anew
    portal.goes(30)
    assert states() == WAITS


def offered(robot, people, portal):
    Queue.objects.update(paused=False)
    portal.goes(4, people["ada"], people["bob"], robot=robot)
    assert [state for state, _ in states()] == ["offered", "waiting"]


@pytest.mark.parametrize("away", ["whole", "web"])
def test_an_offer_that_ran_out_meanwhile_costs_no_place_and_is_made_again(waiting, people, portal, away):
    offered(waiting, people, portal)
    if away == "whole":
        portal.off(ABSENT_S)
    else:
        portal.web = False
        portal.goes(ABSENT_S)
        portal.web = True
    queue_tick()
    assert Ticket.objects.filter(state="expired").count() == 0
    portal.goes(4, people["bob"], robot=waiting)
    assert [state for state, _ in states()] == ["waiting", "waiting"], "ada's page may not be back yet"
    portal.goes(4, people["ada"], people["bob"], robot=waiting)
    assert [state for state, _ in states()] == ["offered", "waiting"], "in the order of before"
    left = Ticket.objects.get(state="offered").offer_until - portal.clock.now()
    assert left.total_seconds() > RULES["OFFER_S"] - 6
    portal.goes(RULES["OFFER_S"] + 6, people["bob"], robot=waiting)
    assert states()[0] == ("expired", "did not answer the offer"), "she could have answered this one"


def test_who_does_not_come_back_holds_nobody_up_for_long(waiting, people, portal):
    offered(waiting, people, portal)
    portal.off(ABSENT_S)
    portal.goes(60, people["bob"], robot=waiting)
    assert [state for state, _ in states()] == ["waiting", "offered"]


@pytest.fixture
def driving(waiting, people, portal):
    """Ada drives, bob waits; her turn is long."""
    offered(waiting, people, portal)
    queue.accept(waiting, people["ada"], portal.clock.now())
    Turn.objects.update(until=portal.clock.now() + timedelta(seconds=2 * HOUR))
    portal.goes(RULES["IDLE_S"] - 30, people["ada"], people["bob"], robot=waiting)
    assert Turn.objects.get().ended_at is None
    return waiting


@pytest.mark.parametrize("closed", [True, False], ids=["her socket was closed", "it was cut off"])
@pytest.mark.parametrize("away", ["whole", "web"])
def test_a_turn_is_not_ended_as_lost_or_idle_for_what_was_not_seen(driving, people, portal, away, closed):
    if closed:  # as a web process that is asked to end does
        queue.note_disconnection(driving, people["ada"], portal.clock.now())
    if away == "whole":
        portal.off(500)
    else:
        portal.web = False
        portal.goes(500)
        portal.web = True
    queue_tick()
    portal.goes(RULES["RECONNECT_S"] - 6)
    assert Turn.objects.get().end_reason == ""
    portal.goes(RULES["IDLE_S"] - 30, people["ada"], people["bob"], robot=driving)
    assert Turn.objects.get().end_reason == ""
    portal.goes(60, people["ada"], people["bob"], robot=driving)
    assert Turn.objects.get().end_reason == "idle while others wait"


def test_a_turn_that_nobody_waits_for_goes_on_while_the_web_is_away(driving, people, portal):
    queue.leave(driving, people["bob"], portal.clock.now())
    end = portal.clock.now() + timedelta(seconds=120)
    Turn.objects.update(base_until=end, until=end)
    portal.web = False
    portal.goes(150)
    assert Turn.objects.get().end_reason == ""
    portal.web = True
    portal.goes(RULES["RECONNECT_S"] + 60, people["ada"], robot=driving)
    assert Turn.objects.get().end_reason == ""


def test_who_does_not_come_back_to_a_turn_loses_it(driving, people, portal):
    queue.note_disconnection(driving, people["ada"], portal.clock.now())
    portal.off(500)
    portal.goes(RULES["RECONNECT_S"] + 6, people["bob"], robot=driving)
    assert Turn.objects.get().end_reason == "connection lost"


def test_an_outage_just_before_the_time_of_day_is_set_counts_against_nobody(waiting, portal):
    portal.off(ABSENT_S)
    uptime.tell()
    for by in (HOUR, -2 * HOUR):
        portal.clock.step(by)
        portal.looks.follow(carry)
        portal.goes(10)
        assert states() == WAITS
        assert web_uptime.up_since(portal.clock.now()) <= portal.clock.now()


def test_what_is_told_ends_after_some_seconds_without_a_web_process(portal):
    for _ in range(2):
        uptime.tell()
        assert 0 < bus.connection().ttl(bus.web_up_key()) <= web_uptime.LASTS_S
