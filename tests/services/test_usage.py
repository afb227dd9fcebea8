"""Counters of a robot's use, of five minutes each, from owners, sockets and composites to the page of statistics."""

import asyncio
import threading
from datetime import UTC, datetime, timedelta

import pytest
from asgiref.testing import ApplicationCommunicator
from django.db import connections
from hypothesis import given
from hypothesis import strategies as st

from portal.live import audience as counting
from portal.live.audience import Audience, write
from portal.live.loop import of_loop
from portal.live.robot_socket import RobotSocket
from portal.live.sessions import SESSIONS
from portal.live.threads import ANYBODY, DRIVERS, EVERYBODY, KNOWN
from robots import services
from robots.models import Lease, Usage
from tests.waiting import CEILING_S
from workers.process import tasks

pytestmark = [pytest.mark.service, pytest.mark.django_db]
POOLS = (DRIVERS, KNOWN, EVERYBODY, ANYBODY, SESSIONS)


@pytest.fixture(autouse=True)
def _no_connection_stays_open():
    """Close the connections of the threads of sockets, which would keep PostgreSQL from dropping the tests' database."""
    yield
    for pool in POOLS:
        executor = pool._executor
        together = threading.Barrier(executor._max_workers)

        def close(together=together):
            together.wait(CEILING_S)  # each thread closes its own
            connections.close_all()

        for ended in [executor.submit(close) for _ in range(executor._max_workers)]:
            ended.result(20)


AT = datetime(2026, 3, 4, 10, 7, 31, 5, tzinfo=UTC)
SLOT = datetime(2026, 3, 4, 10, 5, tzinfo=UTC)


@given(st.datetimes(datetime(2001, 1, 1), datetime(2200, 1, 1), timezones=st.just(UTC)))
def test_each_moment_lies_in_five_minutes_of_the_clock(now):
    slot = services.slot_of(now)
    assert slot <= now < slot + services.usage.SLOT
    assert (slot.minute % 5, slot.second, slot.microsecond) == (0, 0, 0)


def test_counters_are_added_to_and_a_removed_robot_is_no_error(robot):
    services.note_usage(robot.pk, SLOT, online_s=60.0, watching=2, sent_bytes=3_000_000_000)
    services.note_usage(robot.pk, SLOT, watching=1, sent_bytes=5)
    row = Usage.objects.get()
    assert (row.at, row.online_s, row.watching, row.sent_bytes) == (SLOT, 60.0, 3, 3_000_000_005)
    write(SLOT, [counting.Increment("no-such-robot", 1, 1)])
    assert Usage.objects.count() == 1


def test_a_robot_is_online_while_its_owner_renews_its_lease(robot, clock):
    assert services.note_online(clock.now(), 60.0) == 0
    lease = Lease.objects.create(robot=robot, epoch=1, expires_at=clock.now() + timedelta(seconds=3))
    assert services.note_online(clock.now(), 60.0) == 1
    assert services.note_online(clock.go(60), 60.0) == 0, "the lease has run out"
    lease.expires_at = clock.now() + timedelta(seconds=3)
    lease.save()
    services.note_online(clock.now(), 7200.0)
    assert sum(Usage.objects.values_list("online_s", flat=True)) == 60.0 + services.usage.LONGEST_S


def test_old_counters_are_deleted_with_old_pictures(robot, clock, trusted, monkeypatch):
    monkeypatch.setattr(tasks, "wall_clock", lambda: trusted)
    for days in (1, 399, 401):
        services.note_usage(robot.pk, services.slot_of(clock.now() - timedelta(days=days)), sent_bytes=days)
    tasks.clean()
    assert set(Usage.objects.values_list("sent_bytes", flat=True)) == {1, 399}


def counted(one, at=AT):
    slot, found = one.take(at)
    return slot, {c.slug: (c.watching, c.sent_bytes) for c in found}


def test_the_most_at_once_of_five_minutes_is_told_once():
    async def watched():
        one = Audience()
        with one.one("arm") as first:
            with one.one("arm") as second, one.one("rat"):
                second.sent_bytes += 10
            first.sent_bytes += 5
            assert counted(one) == (SLOT, {"arm": (2, 15), "rat": (1, 0)})
            assert counted(one, AT + timedelta(minutes=1)) == (SLOT, {}), "nothing is told twice"
            with one.one("arm"), one.one("arm"):
                pass
            assert counted(one, AT + timedelta(minutes=2)) == (SLOT, {"arm": (1, 0)}), "three by now"
            later = SLOT + timedelta(minutes=5)
            assert counted(one, AT + timedelta(minutes=5)) == (later, {"arm": (1, 0)}), "who is still there"
        return counted(one, AT + timedelta(minutes=10))

    assert asyncio.run(watched())[1] == {"arm": (1, 0)}, "somebody was there until now"


@pytest.mark.django_db(transaction=True)
def test_two_processes_add_up_and_the_last_minute_is_written_after_the_last_has_gone(robot, monkeypatch):
    monkeypatch.setattr(counting, "EVERY_S", 0.05)

    async def process(watchers, size):
        one = Audience()
        for _ in range(watchers):
            with one.one(robot.slug) as seat:
                seat.sent_bytes += size
                await asyncio.sleep(0.2)
        await asyncio.wait_for(asyncio.shield(one._task), CEILING_S)

    for size in (7, 30):
        asyncio.run(process(1, size))
    assert sum(Usage.objects.values_list("sent_bytes", flat=True)) == 37
    assert max(Usage.objects.values_list("watching", flat=True)) <= 2


@pytest.mark.timed
@pytest.mark.django_db(transaction=True)
def test_a_socket_is_a_visitor_and_what_it_is_sent_is_counted(robot, redis_server):
    async def visit():
        path, route = f"/ws/robots/{robot.slug}/", {"kwargs": {"slug": robot.slug}}
        scope = {"type": "websocket", "path": path, "url_route": route, "headers": [], "subprotocols": []}
        socket = ApplicationCommunicator(RobotSocket.as_asgi(), scope)
        await socket.send_input({"type": "websocket.connect"})
        assert (await socket.receive_output(10))["type"] == "websocket.accept"
        size = len((await socket.receive_output(10))["text"])
        during = counted(of_loop().audience)[1][robot.slug]
        await socket.send_input({"type": "websocket.disconnect", "code": 1000})
        await socket.wait(10)
        counted(of_loop().audience, AT)  # what was sent while it ended
        return size, during, counted(of_loop().audience, AT + timedelta(minutes=5))[1]

    size, (watching, sent), after = asyncio.run(visit())
    assert watching == 1
    assert sent >= size > 100
    assert after == {}, "nobody is there any more"


def test_the_page_of_statistics_tells_them(shuttle, clock, client, monkeypatch):
    monkeypatch.setattr("portal.web.statistics.views.SYSTEM", clock)
    slot = services.slot_of(clock.now() - timedelta(hours=2))
    services.note_usage(shuttle.pk, slot, online_s=300.0, watching=4, sent_bytes=6_000_000)
    services.note_usage(shuttle.pk, slot + timedelta(minutes=5), online_s=132.0, watching=3, sent_bytes=3_000_000)
    services.note_usage(shuttle.pk, slot - timedelta(days=1), online_s=300.0, watching=9, sent_bytes=1)
    rows = {r["label"]: r["value"] for r in client.get("/robots/mercury/statistics.json").json()["rows"]}
    assert rows["Time online"] == pytest.approx(0.5)
    assert rows["Most visitors at once"] == 4
    assert rows["Sent to visitors, live"] == pytest.approx(9.0)
    assert rows["Sent to visitors, live, on average"] == pytest.approx(8000 * 9.0 / 86400)
    page = client.get("/robots/mercury/statistics/").content.decode()
    assert "Most visitors at once" in page
    assert "9.0 MB" in page
