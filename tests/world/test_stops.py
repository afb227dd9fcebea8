"""Promises 6, 7 and 8 in virtual time: a stop overtakes everything, a stopped robot stays stopped."""

import random

from robots import bus, services
from robots.models import Robot
from tests.world.delays import Delays
from tests.world.portal import EACH
from tests.world.seeds import hunt, hunts, seeds


def busy(seed):
    return Delays(seed, share=0.01, mean_s=0.1, longest_s=1.0)


def stops(portal, number, within_s):
    """Stop in mid-motion again and again, with moves queued; nothing moves until the release."""
    portal.grant()
    dice = random.Random(portal.world.seed)
    for _ in range(number):
        for _ in range(3):
            portal.move()
        portal.in_motion()
        portal.world.sleep(dice.random() * 0.3)
        took = portal.stop()
        assert took <= within_s, f"at rest {took:.3f} s after the stop"
        begun = len(portal.motions())
        portal.all_final()
        portal.world.sleep(dice.random() * 3)
        assert not portal.rig.moving
        assert len(portal.motions()) == begun, "something moved after the stop"
        portal.release()
        portal.world.sleep(0.3)
        assert not portal.rig.moving, "the release moved something"


@EACH
@seeds(1, 30, 300)
def test_a_stop_overtakes_everything(worlds, seed):
    hunt(worlds, seed, lambda portal: stops(portal, 5, 0.3))


@EACH
@seeds(1, 30, 300)
def test_a_stop_on_a_busy_machine(worlds, seed):
    hunt(worlds, seed, lambda portal: stops(portal, 5, 3.0), busy)


@EACH
@hunts(1, 30, 300)
def test_a_held_motion_ends_with_its_controls(portal):
    portal.grant()
    dice, world = random.Random(portal.world.seed), portal.world
    portal.final(portal.move())
    for i in range(5):
        kind, args = portal.wishes.jog((-1) ** i)
        command = portal.issue(kind, **args)

        def alive(command=command):
            bus.send_keep_alive(portal.slug, command.pk, True)
            world.sleep(0.07)
            return portal.rig.moving

        portal.until(alive, 5, "a motion")
        for _ in range(dice.randrange(3, 12)):
            bus.send_keep_alive(portal.slug, command.pk, True)
            last = world.monotonic()
            world.sleep(0.08)
        assert portal.final(command).state == "cancelled"
        portal.at_rest()
        took = portal.moved_until - last
        assert took <= 0.5, f"at rest {took:.3f} s after the last keep-alive"


@hunts(1, 30, 300)
def test_a_press_after_a_release_counts(portal):
    """Press again after the release of a stop whose hold is still under way: the later press counts."""
    portal.grant()
    dice, world = random.Random(portal.world.seed), portal.world
    for _ in range(3):
        portal.rig.fault("awol")  # a hold is not confirmed before its line gives up
        bus.send_stop(portal.slug)
        world.sleep(dice.random() * 2.5)
        portal.until(lambda: portal.row.stop_latched, 10, "the row of the stop")
        services.release_stop(portal.robot, portal.people["ada"], checked=True)
        world.sleep(dice.random() * 3)
        bus.send_stop(portal.slug)
        world.sleep(0.5)
        portal.rig.clear_faults()
        world.sleep(5)
        assert portal.owner.latch.latched, "the press after the release was lost"
        assert portal.row.stop_latched
        portal.release()
        portal.works_on()


@hunts(1, 30, 300)
def test_a_release_after_a_press_counts(portal):
    """Release a stop that is pressed again while the hold of the first is under way: the release counts, it came last."""
    portal.grant()
    dice, world = random.Random(portal.world.seed), portal.world
    for _ in range(3):
        portal.rig.fault("awol")
        Robot.objects.filter(pk=portal.robot.pk).update(stop_latched=True)
        portal.until(lambda: portal.owner.latch.latched, 10, "the latch")
        world.sleep(dice.random())
        bus.send_stop(portal.slug)
        world.sleep(0.1 + dice.random() * 0.5)
        services.release_stop(portal.robot, portal.people["ada"], checked=True)
        world.sleep(3)
        portal.rig.clear_faults()
        world.sleep(5)
        assert not portal.row.stop_latched, "the stop came back after its release"
        assert not portal.owner.latch.latched
        portal.works_on()
