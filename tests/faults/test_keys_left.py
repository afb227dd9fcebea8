"""Owners that begin and die again and again leave nothing in Redis: each key has an end, or is one of a fixed number."""

import pytest
from celery import current_app

from robots import bus, services
from robots.bus import queue_name
from robots.models import Robot
from robots.states import Cycle, GrantEnd
from tests.conftest import AT_LENGTH, wait_for
from workers.process.queues import forget_earlier

pytestmark = pytest.mark.timed

TIMES = 50 if AT_LENGTH else 4


def without_an_end():
    """Return the names of the keys that stay until somebody removes them."""
    store = bus.connection()
    found = {key for key in store.scan_iter() if store.ttl(key) == -1}
    shared = {key for key in found if b"binding" in key and b".robot." not in key}
    assert not [one for key in shared for one in store.smembers(key) if b"robot." in one], (
        "no queue of an epoch in them"
    )
    return {key.decode() for key in found}


def bound(slug):
    return {key for key in without_an_end() if f"robot.{slug}." in key}


def bindings(epoch):
    return {f"_kombu.{kind}.robot.mercury.{epoch}" for kind in ("binding", "binding_permanent")}


@pytest.mark.parametrize("which", ["mercury"], indirect=True)
def test_the_number_of_keys_stays_as_it_is(rig):
    counts = []
    for _ in range(TIMES):
        before = rig.lease().epoch if rig.lease() else 0
        child = rig.start_worker()
        wait_for(lambda before=before: rig.lease() and rig.lease().epoch > before, 60, "the next owner")
        now = rig.lease().epoch
        wait_for(lambda now=now: bound("mercury") == bindings(now), 30, "its queue alone")
        rig.wait_ready()
        rig.grant()
        assert rig.final(rig.issue("up")).state == "completed"
        counts.append(len(without_an_end()))
        services.end_grant(services.open_grant(rig.robot), GrantEnd.HOLDER, "left", rig.now())
        Robot.objects.update(cycle=Cycle.HANDOVER)
        child.kill()
    assert len(set(counts[1:])) == 1, counts


def test_queues_of_earlier_owners_go_with_their_messages_and_those_of_other_robots_stay(redis_server):
    store = bus.connection()
    store.flushall()
    for epoch in range(1, 51):
        current_app.send_task(bus.WAKE_TASK, queue=queue_name("mercury", epoch), ignore_result=True, retry=False)
    for other in ("mercury-2", "mercur", "m*"):
        current_app.send_task(bus.WAKE_TASK, queue=queue_name(other, 1), ignore_result=True, retry=False)
    current_app.send_task(bus.WAKE_TASK, queue=queue_name("mercury", 51), ignore_result=True, retry=False)
    assert len(bound("mercury")) == 153
    forget_earlier("mercury", 50)
    later = {queue_name("mercury", 51), *bindings(51)}  # of the next owner
    assert bound("mercury") == {queue_name("mercury", 50), *bindings(50), *later}
    assert len(bound("mercury-2")) == len(bound("mercur")) == 3
