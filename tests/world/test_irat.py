"""The iRat in virtual time: its owner, driver, brain and rosbridge over the simulated maze."""

import random

import pytest

from tests.world.seeds import hunt, seeds

pytestmark = pytest.mark.parametrize("which", ["irat"], indirect=True)
REST_S = 0.25 + 0.25  # its watchdog, and the braking from the speed of hands


def held(portal, number=0):
    """Begin a held motion, and wait until the robot moves."""
    command = portal.move(number)
    portal.in_motion()
    return command


def stops(portal):
    portal.grant()
    dice = random.Random(portal.world.seed)
    for i in range(5):
        command = held(portal, i)
        portal.world.sleep(dice.random())
        took = portal.stop()
        assert took <= 0.3, f"at rest {took:.3f} s after the stop"
        begun = len(portal.motions())
        assert portal.final(command).state == "cancelled"
        portal.world.sleep(dice.random() * 2)
        assert len(portal.motions()) == begun, "something moved after the stop"
        portal.controls.let_go()
        portal.release()
        portal.world.sleep(0.3)
        assert not portal.rig.moving, "the release moved something"


@seeds(2, 20, 200)
def test_a_stop_overtakes_a_held_drive(worlds, seed):
    hunt(worlds, seed, stops)


def lost_controls(portal):
    portal.grant()
    dice = random.Random(portal.world.seed)
    for i in range(5):
        command = held(portal, i)
        portal.world.sleep(dice.random())
        assert portal.rig.moving, "it moves for as long as the controls are held"
        portal.controls.let_go()
        portal.at_rest()
        took = portal.world.monotonic() - portal.controls.last
        assert took <= 0.5, f"at rest {took:.3f} s after the last keep-alive"
        assert portal.final(command).state == "cancelled"


@seeds(2, 20, 200)
def test_a_held_drive_ends_with_its_controls(worlds, seed):
    hunt(worlds, seed, lost_controls)


def lost_connection(portal):
    portal.grant()
    command = held(portal)
    at = portal.world.monotonic()
    portal.rig.network.unplug()
    portal.at_rest()
    assert portal.world.monotonic() - at <= REST_S
    assert portal.final(command).state in ("failed", "cancelled", "unknown")
    portal.until(lambda: portal.row.reason, 10, "a word of it")
    portal.world.sleep(random.Random(portal.world.seed).random() * 20)
    portal.rig.network.plug()
    portal.until(lambda: not portal.row.reason, 60, "another connection")
    begun = len(portal.motions())
    portal.world.sleep(2)
    assert len(portal.motions()) == begun, "something moved by itself"
    held(portal, 1)


@seeds(2, 20, 200)
def test_a_lost_connection_holds_the_robot_and_it_is_connected_again(worlds, seed):
    hunt(worlds, seed, lost_connection)


def killed(portal):
    portal.grant()
    command = held(portal)
    at = portal.world.monotonic()
    portal.supervisor.worker.kill()
    portal.at_rest()
    assert portal.world.monotonic() - at <= REST_S
    portal.controls.let_go()
    assert portal.final(command).state == "unknown"
    portal.until(lambda: portal.owner, 30, "another owner")
    begun = len(portal.motions())
    portal.world.sleep(2)
    assert len(portal.motions()) == begun, "something moved by itself"


@seeds(2, 20, 200)
def test_a_kill_of_its_owner_in_mid_motion(worlds, seed):
    hunt(worlds, seed, killed)


def frozen(portal):
    portal.grant()
    held(portal)
    portal.world.sleep(0.5)
    worker = portal.supervisor.worker.process
    at = portal.world.monotonic()
    portal.world.freeze(worker)
    portal.at_rest()
    assert portal.world.monotonic() - at <= REST_S
    assert portal.rig.journal()[-1]["end"] == "silence"
    portal.world.thaw(worker)
    portal.controls.let_go()
    portal.all_final()


@seeds(2, 20, 200)
def test_a_frozen_owner_is_forgotten_by_the_robot(worlds, seed):
    hunt(worlds, seed, frozen)


def explored(portal, seconds=30.0):
    portal.grant()
    command = portal.issue("explore")
    portal.in_motion()
    portal.world.sleep(seconds)
    way = portal.rig.sim.world.driven
    portal.stop()
    assert portal.final(command).state == "cancelled"
    return way


@seeds(1, 10)
def test_it_explores(worlds, seed):
    def run(portal):
        assert explored(portal) > 1.0

    hunt(worlds, seed, run)


def test_the_same_seed_makes_the_same_history(worlds):
    def history(seed):
        portal = worlds(seed)
        explored(portal, 10.0)
        return portal.world.history, portal.rig.sim.world.plant.pose

    first = history(3)
    assert history(3) == first
    assert history(4) != first
