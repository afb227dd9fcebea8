"""The connection is lost in motion and Stop is pressed: no page says that the robot rests before the robot does."""

import time

import pytest
from django.contrib.auth.models import AnonymousUser

from portal.live.snapshot import snapshot
from robots import services
from robots.kit.clock import SYSTEM
from robots.models import Robot
from tests.conftest import at_length, wait_for

# ruff: noqa: TID251 - its tests are timed
pytestmark = pytest.mark.timed


def stop_shown(rig):
    return snapshot(rig.robot.slug, AnonymousUser(), SYSTEM.now(), True)["stop"] or {}


@pytest.mark.parametrize("which", ["mercury"], indirect=True)
def test_an_arm_that_holds_and_cannot_say_so(rig):
    rig.owner()
    rig.grant(seconds=600)
    Robot.objects.update(settings={"speed": 0.1})
    rig.swept()
    rig.issue("move", x=-0.2, y=0.5)
    rig.moving()
    rig.sim.fault("mute")
    pressed = time.time()
    services.stop(rig.robot, rig.people["ada"])
    wait_for(lambda: stop_shown(rig).get("rests_by_ms"), 30, "the time by which it rests")
    shown = stop_shown(rig)
    assert shown["confirmed"] is False
    assert pressed + rig.robot.spec().rest_s <= shown["rests_by_ms"] / 1000
    wait_for(lambda: not rig.sim.status()["moving"], 40, "the hold was heard all the same")
    assert stop_shown(rig)["confirmed"] is False, "nobody heard it say so"
    rig.sim.clear()
    wait_for(lambda: stop_shown(rig)["confirmed"], 30, "it answers at rest")
    assert stop_shown(rig)["rests_by_ms"] is None


@pytest.mark.parametrize("which", [at_length("pa10")], indirect=True)
def test_an_arm_that_hears_nothing_rests_by_the_time_that_is_shown(rig):
    proxy = rig.line_proxy()
    rig.grant(seconds=600)
    rig.share = 0.05
    rig.issue("move", x=0.2, y=0.4)
    rig.moving()
    proxy.set("stall")
    services.stop(rig.robot, rig.people["ada"])
    wait_for(lambda: stop_shown(rig).get("rests_by_ms"), 30, "the time by which it rests")
    rests_by = stop_shown(rig)["rests_by_ms"] / 1000
    wait_for(lambda: not rig.sim.status()["moving"], 40, "rest without a word")
    assert time.time() <= rests_by
    assert stop_shown(rig)["confirmed"] is False
    proxy.set("pass")
    wait_for(lambda: stop_shown(rig)["confirmed"], 60, "it answers at rest")
