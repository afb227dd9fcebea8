"""One robot in virtual time for `make quick`: it moves once, is stopped in mid-motion, and moves again after that."""

from tests.world.seeds import hunt


def a_turn(portal):
    portal.grant()
    begun = len(portal.motions())  # it was homed
    assert portal.final(portal.move()).state == "completed"
    stopped = portal.move()
    portal.in_motion()
    assert portal.stop() <= 0.3
    assert portal.final(stopped).state == "cancelled"
    portal.release()
    assert portal.final(portal.move()).state == "completed"
    assert len(portal.motions()) == begun + 3


def test_smoke(worlds):
    hunt(worlds, 1, a_turn)
