"""The iRat in virtual time: its owner, driver, brain and rosbridge over the simulated maze."""

import random
from math import dist

import pytest

from robots.kit.drivers.irat.driver import NEVER_BEGAN
from tests.world.seeds import hunt, seeds
from tests.world.steps import held, moved_by, nothing_moves, rested, stop_each

pytestmark = pytest.mark.parametrize("which", ["irat"], indirect=True)
REST_S = 0.25 + 0.25  # its watchdog, and the braking from the speed of hands
exploring = moved_by("explore")


@seeds(1, 20, 200)
def test_a_stop_overtakes_a_held_drive(worlds, seed):
    hunt(worlds, seed, lambda portal: stop_each(portal, [held] * 5, 0.25))


@seeds(1, 10, 100)
def test_a_stop_overtakes_an_exploration(worlds, seed):
    hunt(worlds, seed, lambda portal: stop_each(portal, [exploring] * 5, 0.5))


def lost_controls(portal):
    portal.grant()
    dice, fastest = random.Random(portal.world.seed), 0.0
    for _ in range(5):
        command = held(portal)
        portal.world.sleep(dice.random())
        assert portal.rig.moving, "it moves for as long as the controls are held"
        forward, left, turn = portal.owner.owned.driver.latest().twist
        assert left == 0.0, "it has two wheels"
        fastest = max(fastest, abs(forward) + abs(turn))
        portal.controls.let_go()
        took = rested(portal, portal.controls.last)
        assert took <= 0.5, f"at rest {took:.3f} s after the last keep-alive"
        assert portal.final(command).state == "cancelled"
    assert fastest > 0.01, "its states tell how fast it is"


@seeds(1, 20, 200)
def test_a_held_drive_ends_with_its_controls(worlds, seed):
    hunt(worlds, seed, lost_controls)


def lost_connection(portal):
    portal.grant()
    command = held(portal)
    at = portal.world.monotonic()
    portal.rig.pull()
    assert rested(portal, at) <= REST_S
    assert portal.rig.journal()[-1]["end"] == "lost"
    assert portal.final(command).state == "failed"
    portal.until(lambda: portal.row.reason, 10, "a word of it")
    portal.world.sleep(random.Random(portal.world.seed).random() * 20)
    portal.rig.plug()
    portal.until(lambda: not portal.row.reason, 60, "another connection")
    nothing_moves(portal, 2)
    held(portal)


@seeds(1, 20, 200)
def test_a_lost_connection_holds_the_robot_and_it_is_connected_again(worlds, seed):
    hunt(worlds, seed, lost_connection)


def killed(portal):
    """Every other time the robot does not hear that the connection has ended: its watchdog alone holds it."""
    unheard = portal.world.seed % 2
    portal.grant()
    command = held(portal)
    portal.world.sleep(0.3)
    at = portal.world.monotonic()
    if unheard:
        portal.rig.stall(5)
    portal.supervisor.worker.kill()
    assert rested(portal, at) <= REST_S
    assert portal.rig.journal()[-1]["end"] == ("silence" if unheard else "lost")
    portal.controls.let_go()
    assert portal.final(command).state == "unknown"
    portal.until(lambda: portal.owner, 30, "another owner")
    nothing_moves(portal, 6)


@seeds(1, 20, 200)
def test_a_kill_of_its_owner_in_mid_motion(worlds, seed):
    hunt(worlds, seed, killed)


def frozen(portal):
    portal.grant()
    held(portal)
    portal.world.sleep(0.5)
    worker = portal.supervisor.worker.process
    at = portal.world.monotonic()
    portal.world.freeze(worker)
    assert rested(portal, at) <= REST_S
    assert portal.rig.journal()[-1]["end"] == "silence"
    portal.world.sleep(random.Random(portal.world.seed).random())
    portal.world.thaw(worker)
    portal.controls.let_go()
    portal.all_final()


@seeds(1, 20, 200)
def test_a_frozen_owner_is_forgotten_by_the_robot(worlds, seed):
    hunt(worlds, seed, frozen)


def lost_brain(portal):
    portal.grant()
    command, world = exploring(portal), portal.world
    world.sleep(5 + random.Random(world.seed).random())
    at, brain = world.monotonic(), portal.rig.brains[-1]
    brain.kill()
    assert rested(portal, at) <= 2.0, "nobody drives by the answers of before"
    portal.in_motion()
    assert portal.rig.brains[-1] is not brain
    portal.stop()
    portal.final(command)


@seeds(1, 10, 100)
def test_a_brain_that_dies_is_started_again_and_the_robot_rests_meanwhile(worlds, seed):
    hunt(worlds, seed, lost_brain)


def goal(portal):
    """Explore, and go back to a place that was seen on the way."""
    portal.grant()
    command, driven, where = exploring(portal), portal.rig.sim.world, {}
    begun = driven.driven

    def gone():
        newest = portal.rig.brains[-1].mind.slam
        where.setdefault(newest.map.count, driven.plant.pose[:2])
        return driven.driven > begun + 3.0

    portal.until(gone, 60, "3 m of exploring")
    portal.stop()
    portal.final(command)
    portal.release()
    slam = portal.rig.brains[-1].mind.slam
    row = slam.map.count - 6
    place, (x, y) = where[row + 1], (float(v) for v in slam.map.poses[row, :2])
    apart = dist(place, driven.plant.pose[:2])
    done = portal.final(portal.issue("goal", map=slam.map_number, x=x, y=y, experience=int(slam.map.ids[row])), 200)
    assert done.state == "completed", done.reason
    assert dist(place, driven.plant.pose[:2]) < max(0.2, apart / 2), "it came near to the place"


@seeds(1, 10, 30)
def test_it_explores_and_goes_to_a_goal(worlds, seed):
    hunt(worlds, seed, goal)


def never_heard(portal):
    """Drive while the line keeps everything back for longer than that: the robot refuses velocities that are so old."""
    portal.grant()
    before = portal.rig.count("motion")
    portal.rig.stall(1.5)
    command = portal.final(portal.move())
    assert portal.rig.count("motion") == before
    assert (command.state, command.reason) == ("failed", NEVER_BEGAN)
    portal.works_on()


@seeds(1, 10, 100)
def test_a_drive_that_the_robot_never_began_is_not_said_to_be_done(worlds, seed):
    hunt(worlds, seed, never_heard)
