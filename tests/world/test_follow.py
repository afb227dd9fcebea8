"""The tool of each arm follows a hand, and rests soon after the hand was lost or has let go: drivers and simulators."""

import numpy as np
import pytest

from robots.kit.arms.described import chain
from robots.kit.arms.follow import HAND, HandLost
from robots.kit.contract.errors import NotPermitted
from tests.world.pa10 import ArmRig
from tests.world.puma import PumaRig
from tests.world.world import World

RESTS_S = 0.5
NEAR_M = 0.0015
STILL = dict.fromkeys((argument.name for argument in HAND), 0.0)


class Hand:
    """A hand that holds the controls of an arm, and the command that follows it."""

    def __init__(self, world, rig, session):
        self.world, self.rig, self.session = world, rig, session
        self.at, self.held, self.error, self.over = dict(STILL), True, None, False
        session.on_steered = lambda: self.at
        world.spawn(self._run, "follow")
        world.until(lambda: rig.moving or self.over, 5, "the motion")

    def _permit(self):
        if not self.held:
            raise NotPermitted("The hand has let go.")

    def _run(self):
        try:
            self.session.execute("follow", dict(STILL), self._permit, lambda stage: None)
        except Exception as error:
            self.error = error
        self.over = True

    def rested(self, seconds):
        """Wait for rest; return how long it took (s)."""
        begun = self.world.monotonic()
        self.world.until(lambda: self.over and not self.rig.moving, seconds, "rest")
        return self.world.monotonic() - begun


@pytest.fixture(params=[ArmRig, PumaRig], ids=["pa10", "puma"])
def arm(request, tmp_path):
    world = World(1)
    rig = request.param(world, tmp_path)
    session = rig.session(rig.driver, "", {"epoch": 1})
    begun = world.monotonic()
    world.until(lambda: world.monotonic() > begun + 1.0, 10, "the simulator")
    if not session.connect().ready:
        session.recover(lambda: None)
    session.execute("ready", {}, lambda: None, lambda stage: None)
    yield world, rig, session
    rig.close()
    world.close()


def tool(rig, session):
    joints = session.state().joints[:6]
    return chain(rig.driver).forward(np.array(joints))[:3, 3]


def following(arm, seconds, **way):
    """Return a hand that has gone so far (m), and that the arm has followed for so long."""
    world, rig, session = arm
    hand = Hand(world, rig, session)
    hand.at = STILL | way
    world.sleep(seconds)
    assert rig.moving
    return hand


def test_it_comes_where_the_hand_is_and_rests_when_the_hand_lets_go(arm):
    world, rig, session = arm
    begin = tool(rig, session)
    hand = Hand(world, rig, session)
    for step in range(1, 31):
        hand.at = STILL | {"dy": -0.002 * step, "dz": 0.001 * step}
        world.sleep(0.1)
    world.sleep(2.0)
    assert tool(rig, session) - begin == pytest.approx([0.0, -0.06, 0.03], abs=NEAR_M)
    hand.held = False
    assert hand.rested(5) <= RESTS_S
    assert isinstance(hand.error, NotPermitted)


def test_a_hand_that_jumps_is_lost_and_the_arm_rests_at_once(arm):
    world, rig, _ = arm
    hand = following(arm, 0.3, dx=-0.05)
    hand.at = STILL | {"dx": 0.2}
    assert hand.rested(5) <= RESTS_S
    assert isinstance(hand.error, HandLost), hand.error
    motions = rig.count("motion")
    world.sleep(3.0)
    assert rig.count("motion") == motions, "nothing goes on by itself"


def test_the_gripper_moves_only_while_the_arm_follows_and_once_for_each_wish(arm):
    world, rig, session = arm
    hand, before = Hand(world, rig, session), rig.count("gripper")
    world.sleep(0.5)
    assert rig.count("gripper") == before, "nobody has asked for it"
    for closed, told in ((1.0, 1), (0.0, 2), (1.0, 3)):
        hand.at = STILL | {"dx": -0.01 * told, "closed": closed}
        world.sleep(1.0)
        assert rig.count("gripper") == before + told
    hand.held = False
    world.until(lambda: hand.over, 5, "the end")
    hand.at = STILL | {"closed": 0.0}
    world.sleep(2.0)
    assert rig.count("gripper") == before + 3


def test_after_a_lost_line_the_arm_holds_where_it_is_and_follows_again(arm):
    """Nothing takes it to a posture of rest by itself, and nothing has to be started anew."""
    world, rig, session = arm
    hand = following(arm, 0.4, dy=-0.05)
    rig.cable.pull()
    world.until(lambda: not rig.moving, 5, "rest")
    hand.held = False
    world.until(lambda: hand.over, 30, "the end")
    motions, where = rig.count("motion"), rig.sim.plant.measured().q[:6].copy()
    world.sleep(10.0)
    assert rig.count("motion") == motions
    assert np.abs(rig.sim.plant.measured().q[:6].copy() - where).max() < 1e-3
    rig.cable.plug()
    session.close()
    session.connect()
    begin = tool(rig, session)
    again = Hand(world, rig, session)
    world.sleep(1.0)
    assert tool(rig, session) == pytest.approx(begin, abs=NEAR_M), "it begins where the arm is, not where the hand was"
    again.at = STILL | {"dz": 0.02}
    world.sleep(2.0)
    assert tool(rig, session) - begin == pytest.approx([0.0, 0.0, 0.02], abs=NEAR_M)
    again.held = False
    assert again.rested(5) <= RESTS_S
