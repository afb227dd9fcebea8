"""Promises 7 and 8 in virtual time: a stop overtakes everything, and a stopped robot stays stopped."""

import random
from datetime import timedelta

import pytest

from robots import bus, services
from robots.models import Command, Robot
from robots.states import COMMAND_FINAL, Cycle, GrantKind

pytestmark = pytest.mark.django_db(transaction=True)


def granted(portal):
    world = portal.world
    world.until(lambda: portal.owner and portal.owner.connection.connected, 60, "the connection")
    world.until(lambda: Robot.objects.get().cycle == Cycle.READY, 120, "the handover")
    Robot.objects.update(cycle=Cycle.OPERATING)
    services.start_grant(
        portal.robot, GrantKind.TURN, world.now(), portal.people["ada"], world.now() + timedelta(hours=9)
    )


def issue(portal, kind, **args):
    grant = services.open_grant(portal.robot)
    return services.issue(portal.robot.slug, portal.people["ada"], kind, args, services.next_seq(grant)).command


def run(portal, stops):
    granted(portal)
    world, dice, took = portal.world, random.Random(portal.world.seed), []
    for i in range(stops):
        for k in range(3):
            issue(portal, "move", x=0.2 * (-1) ** (i + k), y=0.35)
        bus.wake_owner(portal.robot.slug, portal.owner.lease.epoch)
        world.until(lambda: portal.rig.moving, 20, "a motion")
        world.sleep(dice.random() * 0.3)
        at = world.monotonic()
        bus.send_stop(portal.robot.slug)
        world.until(lambda: not portal.rig.moving, 5, "rest")
        took.append(world.monotonic() - at)
        world.until(lambda: Robot.objects.get().stop_latched, 10, "the row")
        world.until(lambda: not Command.objects.exclude(state__in=COMMAND_FINAL).exists(), 30, "the ends")
        services.release_stop(portal.robot, portal.people["ada"], checked=True)
        world.until(lambda: not portal.owner.latch.latched, 5, "the release")
        world.sleep(0.3)
    return took


@pytest.mark.parametrize("seed", [1, 1, 2])
def test_a_stop_overtakes_everything(worlds, seed):
    portal = worlds(seed)
    took = run(portal, 5)
    print(seed, max(took), portal.world.history, portal.world.switches, portal.world.waits)
    assert max(took) <= 0.3, took
