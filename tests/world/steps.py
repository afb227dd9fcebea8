"""What tests of a rover in virtual time do again and again: drive by hand, stop, and see that nothing moves."""

import random
from math import inf


def held(portal):
    """Begin a motion that is held until its controls are lost, and wait until the robot moves."""
    portal.controls.moment_s = inf
    command = portal.move()
    portal.in_motion()
    return command


def moved_by(kind, **args):
    """Return a function that issues such a command, and waits until the robot moves."""

    def begin(portal):
        command = portal.issue(kind, **args)
        portal.in_motion()
        return command

    return begin


def rested(portal, since):
    """Wait until the robot rests; return how long that took (s)."""
    portal.at_rest()
    return portal.world.monotonic() - since


def nothing_moves(portal, seconds):
    """Fail if a motion begins within so many seconds."""
    begun = len(portal.motions())
    portal.world.sleep(seconds)
    assert not portal.rig.moving
    assert len(portal.motions()) == begun, "something moved by itself"


def stop_each(portal, begins, within_s):
    """Stop in the middle of each motion, which one of `begins` begins; nothing moves until the next."""
    portal.grant()
    dice = random.Random(portal.world.seed)
    for begin in begins:
        command = begin(portal)
        portal.world.sleep(dice.random())
        took = portal.stop()
        assert took <= within_s, f"at rest {took:.3f} s after the stop"
        assert portal.final(command).state == "cancelled"
        nothing_moves(portal, dice.random() * 2)
        portal.controls.let_go()
        portal.release()
        nothing_moves(portal, 0.3)
