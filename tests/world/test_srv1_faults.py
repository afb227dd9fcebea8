"""The hall rover with blind infrared, ghosts of its sonar, a dead encoder, a moved showcase: judged by the truth."""

import random
from math import dist, inf, pi

import pytest

from robots.kit.drivers.srv1.hall import hall
from robots.kit.drivers.srv1.motions import ENCODER, IN_THE_WAY, TOO_NEAR
from robots.kit.drivers.srv1.whereabouts import KNOWN_M
from tests.world.seeds import hunts

pytestmark = pytest.mark.parametrize("which", ["srv1"], indirect=True)
LOOK_S = 0.05
SLACK_M, SHARE = 0.1, 2.0  # a spread holds it 95 times of 100: twice as far away it hardly ever is
DOOR, BLACK = hall().nodes[0].at, next(case for case in hall().cases if case.black)


class Truth:
    """Looks at the simulated rover for as long as the world goes on."""

    def __init__(self, portal):
        self._portal, self._plant = portal, portal.rig.sim.world.plant
        self.touched, self.surer = set(), []
        world = portal.world
        world.spawn(self._watch, "judge", world.process("judge", delayed=False))

    def _watch(self):
        while True:
            self._portal.world.sleep(LOOK_S)
            self.touched |= set(self._plant.contacts)
            owner = self._portal.owner
            state = owner.owned.driver.latest() if owner else None
            if state is None or not state.pose:
                continue
            off, spread = dist(state.pose[:2], self._plant.pose[:2]), state.values["spread"]
            if off > max(SLACK_M, SHARE * spread) or spread > KNOWN_M:
                self.surer.append((off, spread))

    def holds(self):
        assert not self.touched, f"it touched {self.touched}"
        assert not self.surer, f"it was {max(self.surer)} m from where it was shown (off, spread)"


def begin(portal, x, y, heading):
    """Put the rover somewhere, with a grant for ada; return what judges it."""
    portal.grant()
    portal.rig.sim.world.plant.put(x, y, heading)
    portal.world.sleep(0.5)
    return Truth(portal)


def at_a_node(portal, dice):
    node = dice.choice(hall().nodes)
    return begin(portal, *node.at, dice.uniform(-pi, pi))


def tour(dice, count):
    """Return the lines of a mission that looks around and goes to some nodes."""
    return ["look around", *(f"go {node.name}" for node in dice.sample(hall().nodes, count))]


def sent(portal, *lines):
    return portal.issue("mission", text="".join(f"{line}\n" for line in lines))


def toured(portal, dice, truth, count, seconds):
    """Let it go to some nodes; a step that cannot be done is named, and it touches nothing."""
    command = portal.final(sent(portal, *tour(dice, count)), seconds)
    assert command.state == "completed" or command.reason.startswith("Step "), command.reason
    truth.holds()


def sent_into_a_moved_showcase(portal, *faults):
    """Move a showcase into its way, and fail unless its mission names the step that this prevents."""
    truth = begin(portal, *DOOR, 0.0)
    for fault in faults:
        portal.rig.fault(fault)
    portal.rig.sim.world.plant.move("Ammonites", 0.5, -0.95)
    command = portal.final(sent(portal, "look around", "go South", "photograph"), 300)
    assert (command.state, command.reason) == ("failed", f"Step 2 of 3, go South: {IN_THE_WAY}")
    truth.holds()


@hunts(1, 10, 100)
def test_it_stops_before_black_glass_by_hand(portal):
    """By hand, straight at a showcase that infrared does not see: the sonar slows it down, and stops it."""
    dice = random.Random(portal.world.seed)
    x = BLACK.at[0] + dice.uniform(-0.4, 0.4)
    truth = begin(portal, x, 5.8, pi / 2 + dice.uniform(-0.2, 0.2))
    portal.controls.moment_s = inf
    command = portal.hold_if_held(portal.issue("drive", forward=1.0, turn=0.0))
    portal.in_motion()
    portal.world.sleep(15)
    truth.holds()
    y = portal.rig.sim.world.plant.pose[1]
    assert BLACK.at[1] - BLACK.half[1] - y < 0.5, "it came near to it"
    assert portal.owner.owned.driver.latest().values["infrared"] > 0.7, "it does not see it by infrared"
    portal.controls.let_go()
    portal.final(command)
    again = portal.hold_if_held(portal.issue("drive", forward=1.0, turn=0.0))
    portal.world.sleep(5)
    portal.controls.let_go()
    assert portal.final(again).reason == TOO_NEAR
    assert portal.rig.sim.world.plant.pose[1] < y + 0.1, "it stands there"
    back = portal.hold_if_held(portal.issue("drive", forward=-0.5, turn=0.0))
    portal.in_motion()
    portal.world.sleep(2)
    assert portal.rig.sim.world.plant.pose[1] < y - 0.1, "it drives back"
    truth.holds()
    portal.controls.let_go()
    portal.final(back)


@hunts(1, 10, 100)
def test_on_patrol_it_turns_away_from_black_glass(portal):
    """By its rules, for a while, from before black glass on: it turns away from that, and from walls at any angle."""
    truth = begin(portal, BLACK.at[0], 6.2, pi / 2)
    command = portal.final(sent(portal, "patrol 30"), 120)
    assert command.state == "completed", command.reason
    assert not truth.touched, f"it touched {truth.touched}"


@pytest.mark.length
@hunts(1, 5, 50)
def test_a_mission_with_blind_infrared_waits_before_what_stands_in_its_way(portal):
    """Infrared sees nothing at all: the sonar shows what was pushed into its way, and the mission says which step."""
    sent_into_a_moved_showcase(portal, "blind_infrared")


@pytest.mark.length
@hunts(1, 10, 100)
def test_ghosts_of_the_sonar_make_it_no_surer(portal):
    """The sonar reads now and then something nearer or farther: it goes slowly, and is not surer than it is."""
    dice = random.Random(portal.world.seed)
    truth = at_a_node(portal, dice)
    portal.rig.fault("sonar_ghost", dice.choice((0.05, 0.15, 0.3)))
    toured(portal, dice, truth, 2, 600)


@hunts(1, 12, 100)
def test_a_dead_encoder_ends_a_mission_and_its_place_is_not_shown(portal):
    """Its odometry is wrong from then on: it stops, says why, and its place is not shown any more."""
    dice = random.Random(portal.world.seed)
    truth = at_a_node(portal, dice)
    assert portal.final(portal.issue("look"), 200).state == "completed"
    portal.rig.fault("dead_encoder", 1 + portal.world.seed % 3)
    patrol = portal.world.seed % 4 == 3
    command = portal.final(sent(portal, "patrol 30" if patrol else "go 4.5 4.0", "read"), 200)
    assert command.state == "failed"
    assert command.reason.startswith("Step 1 of 2, ")
    assert command.reason.endswith(ENCODER)
    state = portal.owner.owned.driver.state()
    assert state.pose == (), "nobody says where it is"
    truth.holds()
    portal.rig.clear_faults()
    again = portal.final(portal.issue("look"), 200)
    assert again.state == "completed", again.reason
    assert portal.owner.owned.driver.state().pose
    truth.holds()


@pytest.mark.length
@hunts(1, 10, 100)
def test_a_dead_encoder_ends_a_permit(portal):
    """A dead encoder ends the permit of a rover that nobody reaches: it cannot know whether it keeps to its area."""
    at_a_node(portal, random.Random(portal.world.seed))
    command = portal.issue("patrol")
    portal.until(lambda: portal.rig.count("permit"), 60, "its permit")
    portal.world.sleep(1.0)
    portal.rig.pull()
    portal.world.sleep(1.0)
    assert portal.rig.moving, "it drives on"
    portal.rig.fault("dead_encoder", 1 + portal.world.seed % 3)
    portal.at_rest(2.0)
    portal.world.sleep(5.0)
    assert not portal.rig.moving
    portal.rig.plug()
    portal.ready_again()
    assert portal.final(command).state == "failed"
    assert portal.owner.owned.driver.state().pose == ()


@pytest.mark.length
@hunts(1, 18, 100)
def test_a_moved_showcase_is_not_hit(portal):
    """A showcase stands elsewhere than on the map: it touches nothing, and a step that cannot be done is named."""
    dice = random.Random(portal.world.seed)
    truth = at_a_node(portal, dice)
    portal.rig.fault("moved_case", 1 + portal.world.seed % len(hall().cases))
    portal.world.sleep(0.5)
    toured(portal, dice, truth, 3, 900)


@pytest.mark.length
@hunts(1, 5, 50)
def test_a_mission_says_which_step_a_moved_showcase_prevents(portal):
    sent_into_a_moved_showcase(portal)
