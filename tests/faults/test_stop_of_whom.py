"""A stop that comes from a turn that is over: not by the bus, not by the database; every other one stops."""

import json
import time

import pytest
from django.conf import settings

from robots import bus, services
from robots.clock import SYSTEM
from robots.drivers.errors import NotPermitted
from robots.models import Robot
from tests.conftest import BOTH_AT_LENGTH, wait_for
from tests.faults.test_promises_stop import drain, socket_of
from tests.rig import Web


def latched(rig):
    return Robot.objects.get().stop_latched or (settings.VAR / "run" / f"{rig.robot.slug}.stopped").exists()


def quiet(heard, seconds=1.5):
    """Wait until nothing more is told, so that what comes after is told by nobody."""

    def still():
        before = len(heard)
        time.sleep(seconds)
        return not any(m["t"] in ("snapshot", "changed") for m in heard[before:])

    wait_for(still, 20, "quiet")


def release(rig):
    wait_for(lambda: latched(rig), 5, "the stop")
    wait_for(lambda: Robot.objects.get().stop_latched, 5, "the row follows")
    services.release_stop(rig.robot, rig.people["kim"], checked=True)
    wait_for(lambda: not latched(rig), 5, "the release")


@BOTH_AT_LENGTH
def test_the_stop_of_a_turn_that_is_over_stops_nobody_else(rig):
    rig.owner()
    before = rig.grant("ada")
    assert rig.final(rig.issue("noop")).state == "completed"
    services.end_grant(before, "ended by the operator", SYSTEM.now())
    now = rig.grant("bob")
    assert rig.final(rig.issue("noop", who="bob")).state == "completed"
    assert bus.ring_stop(rig.robot.slug, before.pk)
    with pytest.raises(NotPermitted):
        services.stop(rig.robot, rig.people["ada"], rung=True)
    time.sleep(0.5)
    assert not latched(rig)
    for grant in (now.pk, 0, now.pk + 1000):  # the operator, staff, one that nobody knows
        bus.ring_stop(rig.robot.slug, grant)
        release(rig)


def test_an_owner_that_has_just_begun_knows_whose_turn_is_over(rig):
    first = rig.owner()
    before = rig.grant("ada")
    services.end_grant(before, "ended by the operator", SYSTEM.now())
    first.kill()
    rig.start_worker()
    wait_for(lambda: rig.lease().epoch == 2 and services.owner_alive(rig.lease(), SYSTEM.now()), 30, "the next owner")
    time.sleep(1.0)
    bus.ring_stop(rig.robot.slug, before.pk)
    time.sleep(0.5)
    assert not latched(rig)


def test_the_page_of_the_operator_stops_and_one_that_missed_the_end_of_its_turn_does_not(rig):
    """Ada's socket knows the last snapshot only, as one does that is kept from reading."""
    rig.owner()
    web = Web()
    try:
        grant = rig.grant("ada")
        with socket_of(web, rig.people["ada"]) as ada:
            heard = drain(ada)
            wait_for(lambda: any(m.get("me", {}).get("operating") for m in heard), 10, "the snapshot")
            ada.send(json.dumps({"t": "stop"}))
            release(rig)
            quiet(heard)
            spoken = bus.connection().pubsub()
            spoken.subscribe(bus.stop_channel(rig.robot.slug))
            # her turn ends in the rows alone: no event tells her page
            type(grant).objects.filter(pk=grant.pk).update(ended_at=SYSTEM.now(), end_reason="over")
            rig.grant("bob")
            time.sleep(0.5)
            ada.send(json.dumps({"t": "stop"}))
            wait_for(lambda: any(m.get("to") == "stop" and not m["ok"] for m in heard), 10, "the refusal")
            word = wait_for(
                lambda: (spoken.get_message(ignore_subscribe_messages=True) or {}).get("data"), 5, "it was rung"
            )
            assert bus.heard_stop(word) == grant.pk
            time.sleep(0.5)
            assert not latched(rig)
    finally:
        web.kill()
