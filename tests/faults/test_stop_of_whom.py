"""A stop from a turn that is over has no effect, by the bus or by the database; every other one stops the robot."""

import pytest
from django.conf import settings

from robots import bus, services
from robots.grants import owner_alive
from robots.kit.clock import SYSTEM
from robots.kit.contract.errors import NotPermitted
from robots.models import Robot
from robots.states import GrantEnd
from tests.conftest import BOTH_AT_LENGTH, wait_for
from tests.looked import heard

pytestmark = pytest.mark.timed


def latched(rig):
    return Robot.objects.get().stop_latched or (settings.VAR / "run" / f"{rig.robot.slug}.stopped").exists()


def release(rig):
    wait_for(lambda: latched(rig), 5, "the stop")
    wait_for(lambda: Robot.objects.get().stop_latched, 5, "the row follows")
    services.release_stop(rig.robot, rig.people["kim"], checked=True)
    wait_for(lambda: not latched(rig), 5, "the release")


@pytest.mark.asvs("8.3.1")
@BOTH_AT_LENGTH
def test_the_stop_of_a_turn_that_is_over_stops_nobody_else(rig):
    rig.owner()
    before = rig.grant("ada")
    assert rig.final(rig.issue("noop")).state == "completed"
    services.end_grant(before, GrantEnd.STAFF, "ended by the operator", SYSTEM.now())
    now = rig.grant("bob")
    assert rig.final(rig.issue("noop", who="bob")).state == "completed"
    assert bus.send_stop(rig.robot.slug, before.pk)
    with pytest.raises(NotPermitted):
        services.stop(rig.robot, rig.people["ada"], sent=True)
    heard(rig, "bob")
    assert not latched(rig)
    for grant in (now.pk, 0, now.pk + 1000):  # the operator, staff, one that nobody knows
        bus.send_stop(rig.robot.slug, grant)
        release(rig)


def test_an_owner_that_has_just_begun_knows_whose_turn_is_over(rig):
    first = rig.owner()
    before = rig.grant("ada")
    services.end_grant(before, GrantEnd.STAFF, "ended by the operator", SYSTEM.now())
    epoch = rig.lease().epoch
    first.kill()
    rig.start_worker()
    wait_for(lambda: rig.lease().epoch > epoch and owner_alive(rig.lease(), SYSTEM.now()), 30, "the next owner")
    listens = bus.stop_channel(rig.robot.slug)
    wait_for(lambda: bus.connection().pubsub_numsub(listens)[0][1], 10, "it listens")
    bus.send_stop(rig.robot.slug, before.pk)
    rig.grant("bob")
    heard(rig, "bob")
    assert not latched(rig)
