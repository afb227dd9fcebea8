"""Promises 6, 7 and 8 in virtual time: a stop overtakes everything, a stopped robot stays stopped."""

import random

from robots import bus
from tests.world.delays import Delays
from tests.world.seeds import hunt, seeds


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


@seeds(3, 30, 300)
def test_a_stop_overtakes_everything(worlds, seed):
    hunt(worlds, seed, lambda portal: stops(portal, 4, 0.3))


@seeds(3, 30, 300)
def test_a_stop_on_a_busy_machine(worlds, seed):
    hunt(worlds, seed, lambda portal: stops(portal, 4, 3.0), busy)


def lost_controls(portal, number, within_s):
    portal.grant()
    dice, world = random.Random(portal.world.seed), portal.world
    portal.final(portal.move())
    for i in range(number):
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
        portal.at_rest()
        took = world.monotonic() - last
        assert took <= within_s, f"at rest {took:.3f} s after the last keep-alive"
        assert portal.final(command).state == "cancelled"


@seeds(3, 30, 300)
def test_a_held_motion_ends_with_its_controls(worlds, seed):
    hunt(worlds, seed, lambda portal: lost_controls(portal, 5, 0.5))
