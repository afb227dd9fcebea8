"""The path of a motion reaches pages before the motion has ended, is true to the arm, and ends with its command."""

import numpy as np
import pytest

from robots import bus
from robots.kit.contract.compact import Layout
from robots.kit.contract.path_packet import TYPE, decode_path
from robots.kit.packets import read_state
from tests.world.seeds import hunts
from tests.world.test_arm import slowly
from tests.world.web import AT_ROBOT, Browser, Page, Sockets

pytestmark = pytest.mark.parametrize("which", ["pa10"], indirect=True)
TOLD_S = 1.0  # until a page has what was sent
OFF_M, OFF_RAD = 0.01, np.radians(2.0)  # what ends a prediction
LATE_S = (0.0, -0.05, 0.05, -0.1, 0.1, -0.15, 0.15)


def opened(portal, sockets):
    """Return a stranger's page that has its snapshot."""
    page = Page(sockets, AT_ROBOT.format(portal.slug))
    portal.until(lambda: page.snapshot, 10, "the snapshot")
    return page


def paths(portal, page):
    """Return the paths that have come to a page."""
    near_ms = int(portal.world.now().timestamp() * 1000)
    layout = Layout.of(portal.robot.spec())
    return [decode_path(layout, data, near_ms) for data in page.packets if data[0] == TYPE]


def states(page):
    return [read_state(data, ()) for data in page.packets if data[0] == 1]


def off(portal, path, state):
    """Return how far a state's tool (m) and joints (rad) are from the path, at the nearest time within its tolerance."""
    chain = portal.rig.sim.app._courses.planner.chain
    q, found = np.array(state.joints[:6]), []
    for late in LATE_S:
        there = np.array(path.path.at(state.at - path.began_ms / 1000 + late))
        far = np.linalg.norm(chain.forward(q)[:3, 3] - chain.forward(there)[:3, 3])
        found.append((float(far), float(np.abs(q - there).max())))
    return min(found)


@hunts(1, 5, 50)
def test_a_page_knows_the_motion_before_it_ends_and_every_state_of_it_lies_on_the_path(portal):
    portal.grant()
    sockets = Sockets(portal.world)
    page = opened(portal, sockets)
    for kind, x in (("move", 0.25), ("line", 0.1), ("move", -0.2)):
        _, place = portal.wishes.spell("move", {"x": x, "y": 0.45}, 0.5)
        page.packets.clear()
        command = portal.issue("joints", **place) if kind == "move" else portal.issue("line", **lower(portal))
        portal.in_motion()
        portal.until(lambda: paths(portal, page), 5, "the path")
        assert portal.rig.moving, "it came too late to be of use"
        (path,) = paths(portal, page)
        assert path.command == command.pk
        assert portal.final(command).state == "completed", command.reason
        portal.world.sleep(TOLD_S)
        told = [one for one in states(page) if path.began_ms <= 1000 * one.at <= path.ends_ms + 300]
        assert len(told) > 3
        for state in told:
            far_m, turned = off(portal, path, state)
            assert far_m <= OFF_M
            assert turned <= OFF_RAD
        page.packets.clear()


def lower(portal):
    """Return the values of a straight line, 8 cm to the side of where the tool is."""
    x, y, z, *angles = portal.owner.owned.driver.latest().pose
    return dict(zip(("x", "y", "z", "roll", "pitch", "yaw", "speed"), (x, y + 0.08, z, *angles, 0.5), strict=True))


@hunts(1, 5, 50)
def test_a_motion_that_takes_the_place_of_another_has_a_path_of_its_own(portal):
    portal.grant()
    page = opened(portal, Sockets(portal.world))
    slowly(portal)
    portal.until(lambda: len(paths(portal, page)) == 1, 5, "the first path")
    portal.world.sleep(1.0)
    _, place = portal.wishes.spell("move", {"x": -0.1, "y": 0.4}, 0.5)
    second = portal.issue("joints", **place)
    portal.until(lambda: len(paths(portal, page)) == 2, 5, "the second path")
    path = paths(portal, page)[1]
    assert path.command == second.pk
    assert portal.final(second).state == "completed", second.reason
    portal.world.sleep(TOLD_S)
    told = [one for one in states(page) if path.began_ms <= 1000 * one.at <= path.ends_ms + 300]
    assert len(told) > 3
    assert max(off(portal, path, state) for state in told) <= (OFF_M, OFF_RAD)


@hunts(1, 5, 50)
def test_who_comes_later_is_given_the_path_that_runs_and_none_that_was_held(portal):
    portal.grant()
    sockets = Sockets(portal.world)
    command = slowly(portal)
    portal.until(lambda: bus.store.connection().get(bus.path_key(portal.slug)), 5, "the path")
    first = opened(portal, sockets)  # the web process has heard nothing of this robot before
    portal.until(lambda: paths(portal, first), TOLD_S, "the path that runs")
    second = opened(portal, sockets)
    portal.until(lambda: paths(portal, second), TOLD_S, "the path that runs, from the web process")
    assert paths(portal, first)[0] == paths(portal, second)[0]
    assert paths(portal, first)[0].command == command.pk
    portal.stop()
    assert portal.final(command).state == "cancelled"
    assert bus.store.connection().get(bus.path_key(portal.slug)) is None
    portal.world.sleep(TOLD_S)
    later = opened(portal, sockets)
    portal.world.sleep(TOLD_S)
    assert not paths(portal, later)
    assert first.newest["command"]["state"] == "cancelled"


@hunts(1, 3, 30)
def test_held_motions_and_the_gripper_have_no_path(portal):
    portal.grant()
    browser = Browser(Sockets(portal.world), portal.people["ada"])
    page = browser.open(AT_ROBOT.format(portal.slug))
    portal.until(lambda: page.snapshot, 10, "the snapshot")
    assert portal.final(portal.issue("gripper", closed=1)).state == "completed"
    jog = portal.hold_if_held(portal.issue("jog_joints", S1=1.0))
    portal.in_motion()
    portal.world.sleep(0.5)
    portal.final(jog)
    portal.world.sleep(TOLD_S)
    assert not paths(portal, page)
