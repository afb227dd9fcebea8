"""A robot that nobody drives, while the web server is halted: by the clock of the test, as long as in the paper."""

import pytest

from queueing import services as queue
from queueing.models import QueueRobot
from queueing.services import Asker, ask
from robots import bus, services
from robots.models import Command, Grant
from robots.states import CommandState, GrantKind
from workers.commands import rows

pytestmark = [pytest.mark.django_db, pytest.mark.timed]
HALTED_MIN = 90  # "approximately one and half hour server downtime"
may_be_watched = bus.may_be_watched


def done(clock, seconds=0.0):
    """Let the owner end what runs, and the queue follow."""
    for command in Command.objects.select_related("robot", "grant").filter(ended_at=None):
        rows.finish(command, CommandState.COMPLETED, clock.go(seconds))
    queue.tick(clock.now())


def test_it_explores_and_serves_for_ninety_minutes_and_rests_once_the_server_is_back_unwatched(
    shuttle, clock, monkeypatch, redis_server
):
    monkeypatch.setattr("robots.bus.may_be_watched", may_be_watched)
    bus.connection().flushall()  # no web process has said for seconds that it lives
    QueueRobot.objects.update(watched_at=clock.now(), rest_after_min=15)
    job = ask(shuttle, Asker(guest="a" * 64, network="192.0.2.1"), "go", {"x": 1.0}, clock.now())
    queue.tick(clock.now())
    done(clock, 30)
    job.refresh_from_db()
    assert job.state == "done"
    for slices in range(1, HALTED_MIN + 1):
        assert services.open_grant(shuttle).kind == "idle"
        assert Grant.objects.filter(kind=GrantKind.IDLE).count() == slices
        done(clock, 60)
    bus.connection().set(bus.web_key(), 1)  # it is back, and nobody watches
    for _ in range(17):
        done(clock, 60)
        clock.go(0 if services.open_grant(shuttle) else 60)
    assert services.open_grant(shuttle) is None
