"""The museum arm's own safety in virtual time: the end of its connection, and its watchdog."""

import random

import pytest

from robots.kit.description import load
from tests.world.motions import Motions
from tests.world.seeds import hunts
from tests.world.test_lines import in_mid_motion

pytestmark = pytest.mark.parametrize("which", ["pa10"], indirect=True)
BRAKES_S = 0.5  # a set-point from the greatest speed, and one look at everything


def slowly(portal):
    """Begin a motion that lasts for longer than the watchdog waits; return its command."""
    _, joints = portal.wishes.spell("move", {"x": 0.25, "y": 0.45}, 0.06)
    command = portal.issue("joints", **joints)
    portal.in_motion()
    portal.world.sleep(random.Random(portal.world.seed).random())
    return command


def told(portal, event):
    return [record for record in portal.rig.journal() if record["event"] == event]


@hunts(1, 10, 100)
def test_the_end_of_a_killed_owners_connection_holds_the_arm(portal):
    portal.grant()
    (connection,) = told(portal, "connected")
    slowly(portal)
    at = portal.world.monotonic()
    portal.supervisor.worker.kill()
    portal.at_rest(BRAKES_S)
    assert [record["cause"] for record in told(portal, "disconnected")] == ["the client closed the line"]
    assert told(portal, "end")[-1]["end"] == "held"
    portal.works_on()
    second = told(portal, "connected")[1]
    assert second["epoch"] > connection["epoch"]
    assert second["t"] > at


@hunts(1, 10, 100)
def test_the_watchdog_holds_the_arm_of_an_owner_who_vanished(portal):
    """An owner's host loses its power: nobody tells the arm that the connection is over."""
    watchdog_s = load("pa10")["line"]["watchdog_s"]
    history = Motions(portal)
    portal.grant()
    command = slowly(portal)
    at = portal.world.monotonic()
    portal.rig.stall(2 * watchdog_s)
    portal.supervisor.worker.kill()
    portal.world.sleep(watchdog_s - 1.0)
    assert portal.rig.moving, "it had no reason to stop yet, or the motion was too short to tell"
    portal.at_rest(1.0 + BRAKES_S)
    assert portal.world.monotonic() - at >= watchdog_s - 0.5
    assert told(portal, "disconnected")[-1]["cause"] == f"watchdog: no line for {watchdog_s:g} s"
    assert portal.final(command).state == "unknown"
    portal.world.sleep(watchdog_s)
    portal.works_on()
    history.check()


@hunts(1, 10, 100)
def test_half_a_line_is_dropped_and_the_end_of_the_connection_holds(portal):
    history = Motions(portal)
    portal.grant()
    in_mid_motion(portal)
    portal.rig.halve()
    portal.at_rest(BRAKES_S)
    assert told(portal, "disconnected")[-1]["cause"] == "half a line, then the end"
    portal.all_final()
    portal.works_on()
    history.check()
