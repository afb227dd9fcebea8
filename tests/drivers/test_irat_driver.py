"""The iRat's driver against its simulator over the real WebSocket, with its brain as a real process."""

import math
import os
import signal
import threading
import time
from pathlib import Path

import cv2
import numpy as np
import pytest
from msgspec.structs import replace

from robots.kit.contract.errors import BadRequest, GaveUp, GrantOver, MotionHeld
from robots.kit.contract.session import Progress
from robots.kit.drivers.irat.brain.messages import Save
from robots.kit.drivers.irat.brain.mind import IN_DOCK_M
from robots.kit.drivers.irat.brain.places import MapCleared
from robots.kit.slam.routes import index_of
from robots.kit.slam.storage import load
from simulators.irat.plant import docked
from tests.conftest import wait_for
from tests.drivers.irat_wire import CLOCK, FASTER, journal, until
from tests.drivers.pa10_wire import allow
from tests.faults.witness import Witness

# a map that answers half a second late holds the robot, so nothing else runs beside it
# ruff: noqa: TID251 - its tests are timed
pytestmark = pytest.mark.timed
FAR_M = IN_DOCK_M + 0.35  # a young map is wrong by that much, of the place and of the dock
SLICES = 5
SMALL = 12  # experiences: a map of a few decimetres


def explored(driver, experiences=SMALL, on_stage=lambda _: None, there=lambda: True):
    """Explore until the map has so many experiences, and the robot is `there`; a slice may end before."""

    def permit():
        if driver.brain.newest.experiences >= experiences and there():
            raise GrantOver("enough")

    for _ in range(SLICES):
        try:
            driver.execute("explore", {}, permit, on_stage)
        except GrantOver:
            return
    raise AssertionError(f"{driver.brain.newest.experiences} of {experiences} experiences, {driver.state()}")


def looked(driver):
    """Return what the newest picture was worth; the camera is kept running."""
    driver.senses.awake()
    return driver.brain.newest.picture


def rests(sim, seconds, harm, mend):
    """Harm what drives; the robot rests within so many of its seconds. Return how often that was done.

    A time during which the machine stalled tells nothing: it is mended and harmed again, up to five times.
    """
    witness = Witness()
    try:
        for times in range(1, 6):
            wait_for(lambda: abs(sim.status()["rims"][0]) > 0.02, 20, "motion")
            since = time.monotonic()
            harm()
            ends = wait_for(lambda since=since: [r["t"] for r in journal(sim, "rest") if r["t"] > since], 10, "rest")
            mend()
            if witness.clean(since, ends[0]):
                assert (ends[0] - since) * FASTER < seconds
                return times
    finally:
        witness.stop()
    raise AssertionError("a measurement: not within five attempts, because the machine stalled")


def kill(driver):
    """Return what kills the brain, and what waits until it is back."""
    return (
        lambda: os.kill(driver.brain.pid, signal.SIGKILL),
        lambda: wait_for(lambda: driver.brain.fresh() is not None, 60, "the brain is back"),
    )


def here(driver, **more):
    """Return the place where the robot stands, as a goal."""
    seen = driver.brain.newest
    x, y, _ = seen.pose
    return {"map": seen.map_number, "x": x, "y": y, "experience": seen.experience} | more


def test_its_camera_is_seen_over_its_own_wire(rat_driver, irat):
    picture = cv2.imdecode(np.frombuffer(rat_driver.picture("robot", 5), np.uint8), cv2.IMREAD_COLOR)
    assert picture.shape == (240, 416, 3)
    irat.fault("cam_gone")
    wait_for(lambda: rat_driver.picture("robot", 0.3) is None, 10, "no picture, once the last one has come")


def test_its_state_is_what_the_robot_and_its_map_tell(rat_driver, irat):
    state = rat_driver.state()
    assert (state.moving, state.ready, state.fault, state.mode) == (False, True, "", "resting")
    assert len(state.pose) == 3
    assert state.values["charge"] == pytest.approx(100 * irat.status()["charge"], abs=1)
    assert 6.4 < state.values["battery"] < 8.5
    assert state.values["charging"] == 0.0
    assert irat.count("motion") == 0, "nothing moves by itself"
    at = rat_driver.state().at
    assert CLOCK.monotonic() - at < 1.0


def test_it_explores_and_its_map_grows_and_is_streamed(rat_driver, irat):
    packets = []
    rat_driver.on_packet = lambda name, data, key: packets.append((name, key)) or False
    before, told = rat_driver.state().values, []
    explored(rat_driver, before["experiences"] + SMALL, told.append)
    state = rat_driver.state()
    assert told == ["sent", "acknowledged"]
    assert (
        state.values["driven"] - before["driven"] == pytest.approx(irat.status()["driven"], rel=0.2)
        or irat.status()["driven"] > 0.2
    )
    assert not state.moving and not irat.status()["moving"], "the end of the permit holds it"
    assert {"map", "cells"} <= {name for name, _ in packets}


def test_a_goal_on_its_map_does_not_begin_without_a_permit(rat_driver, irat):
    explored(rat_driver)
    irat.forget()

    def refused():
        raise GrantOver("The turn is over.")

    with pytest.raises(GrantOver):
        rat_driver.execute("goal", here(rat_driver), refused, lambda _: None)
    assert not rat_driver.state().moving, "answered after all that was sent"
    assert irat.count("motion") == 0


def test_a_brain_that_dies_rests_the_wheels_and_comes_back_with_its_map(rat_driver, irat):
    explored(rat_driver)
    rat_driver.brain.call(Save)
    known, number = rat_driver.brain.newest.experiences, rat_driver.brain.newest.map_number
    permit, starts = until(350 * FASTER), rat_driver.brain.starts

    def roam():
        with pytest.raises(MotionHeld):
            rat_driver.execute("explore", {}, permit, lambda _: None)

    thread = threading.Thread(target=roam)
    thread.start()
    times = rests(irat, 1.0, *kill(rat_driver))  # 0.5 s of silence, and the braking
    assert rat_driver.brain.starts == starts + times
    assert rat_driver.brain.newest.map_number == number
    assert rat_driver.brain.newest.experiences >= known
    wait_for(lambda: irat.status()["moving"], 10, "it goes on")
    rat_driver.hold()
    thread.join(30)


def test_a_frozen_brain_rests_the_wheels(rat_driver, irat):
    def roam():
        with pytest.raises(MotionHeld):
            rat_driver.execute("explore", {}, allow, lambda _: None)

    thread = threading.Thread(target=roam)
    thread.start()
    brain = rat_driver.brain.pid

    def thaw():
        assert max(map(abs, irat.status()["reference"])) == 0.0
        assert irat.status()["moving"] is False
        os.kill(brain, signal.SIGCONT)

    try:
        rests(irat, 1.1, lambda: os.kill(brain, signal.SIGSTOP), thaw)
    finally:
        os.kill(brain, signal.SIGCONT)
    wait_for(lambda: irat.status()["moving"], 10, "it goes on")
    rat_driver.hold()
    thread.join(10)


def test_black_and_frozen_pictures_teach_nothing(rat_driver, irat):
    explored(rat_driver, SMALL)
    for fault, word in (("cam_black", "black"), ("cam_freeze", "frozen")):
        wait_for(lambda: looked(rat_driver) == "seen", 10, "a good picture")
        irat.fault(fault)
        wait_for(lambda word=word: looked(rat_driver) == word, 10, fault)
        known = rat_driver.brain.newest.experiences
        with pytest.raises(GrantOver):
            rat_driver.execute("explore", {}, until(1.5), lambda _: None)
        assert rat_driver.brain.newest.experiences == known, fault
        irat.clear()


def away(driver, irat):
    """Explore until the robot stands so far from the dock that its place can be a goal, and return it.

    Without a hold on the way: one that comes with each new experience keeps the robot from turning out of the dock.
    """
    explored(driver, there=lambda: math.dist(irat.status()["pose"][:2], docked()[:2]) >= FAR_M)
    return here(driver)


def went(driver, irat, tries=3):
    """Explore, and go back to where that began; a goal may be given up, so at most so many times."""
    for left in reversed(range(tries)):
        goal, told = away(driver, irat), []
        explored(driver, driver.brain.newest.experiences + SMALL)
        try:
            return goal, told, driver.execute("goal", goal, allow, told.append)
        except GaveUp:
            if not left:
                raise
    raise AssertionError


def test_a_goal_is_reached_when_the_map_says_so(rat_driver, irat):
    folder = Path(rat_driver.settings["folder"]) / "brain"
    goal, told, outcome = went(rat_driver, irat)
    assert outcome.sent["experience"] == goal["experience"]
    assert outcome.sent["limit_s"] >= 30.0
    rat_driver.brain.call(Save)
    held = load(folder / "map.npz").map
    reached, current = index_of(held, goal["experience"]), held.poses[held.current, :2]
    assert np.hypot(*(held.poses[reached, :2] - current)) < 0.15, "by its own map, once it rests"
    assert not outcome.state.moving
    assert told[:2] == ["sent", "acknowledged"]
    assert all(isinstance(t, Progress) for t in told[2:])


def test_a_brain_that_dies_in_a_goal_rests_the_wheels_and_goes_on_to_the_same_place(rat_driver, irat):
    goal, ends = away(rat_driver, irat), []
    explored(rat_driver, rat_driver.brain.newest.experiences + 2 * SMALL)
    rat_driver.brain.call(Save)

    def go():
        try:
            ends.append(rat_driver.execute("goal", goal, allow, lambda _: None).sent["experience"])
        except GaveUp as error:
            ends.append(str(error))

    thread = threading.Thread(target=go)
    thread.start()
    rests(irat, 1.0, *kill(rat_driver))
    wait_for(lambda: irat.status()["moving"] or ends, 10, "it goes on")
    thread.join(200)
    assert not thread.is_alive()
    assert ends[0] == goal["experience"] or "was not reached within" in ends[0]
    assert irat.status()["moving"] is False


def test_a_goal_that_is_not_on_the_map_is_refused_with_a_sentence(rat_driver, irat):
    explored(rat_driver)
    for wrong, error, words in (
        (here(rat_driver, map=rat_driver.brain.newest.map_number + 1), MapCleared, "cleared"),
        ({"map": rat_driver.brain.newest.map_number, "x": 50.0, "y": 50.0}, BadRequest, "No place on the robot's map"),
    ):
        irat.forget()
        with pytest.raises(error, match=words):
            rat_driver.execute("goal", wrong, allow, lambda _: None)
        assert irat.count("motion") == 0


def test_a_cleared_map_is_a_new_one_and_its_goals_are_gone(rat_driver, irat):
    explored(rat_driver)
    old = here(rat_driver)
    rat_driver.execute("clear_map", {}, allow, lambda _: None)
    rat_driver.senses.awake()
    wait_for(lambda: rat_driver.brain.newest.map_number == old["map"] + 1, 5, "the new map")
    with pytest.raises(MapCleared):
        rat_driver.execute("goal", old, allow, lambda _: None)


def test_a_map_that_staff_clear_on_the_way_ends_its_goal(rat_driver, irat):
    goal = away(rat_driver, irat)
    explored(rat_driver, rat_driver.brain.newest.experiences + SMALL)

    def clear():
        wait_for(lambda: irat.status()["moving"], 10, "motion")
        rat_driver.execute("clear_map", {}, allow, lambda _: None)

    thread = threading.Thread(target=clear)
    thread.start()
    with pytest.raises(MapCleared, match="on the way"):
        rat_driver.execute("goal", goal, allow, lambda _: None)
    thread.join()
    assert not rat_driver.state().moving


def test_a_goal_that_takes_too_long_is_given_up(rat_driver, irat, monkeypatch):
    goal = away(rat_driver, irat)
    explored(rat_driver, rat_driver.brain.newest.experiences + SMALL)
    answer = rat_driver.brain.call

    def soon(make, *more):
        return replace(answer(make, *more), limit_s=1.0)

    monkeypatch.setattr(rat_driver.brain, "call", soon)
    with pytest.raises(GaveUp, match="not reached within 1 s"):
        rat_driver.execute("goal", goal, allow, lambda _: None)
    assert not rat_driver.state().moving


def test_staff_drive_by_hand_while_they_hold_the_controls(rat_driver, irat):
    with pytest.raises(GrantOver):
        rat_driver.execute("drive", {"forward": -1.0, "turn": 0.0}, until(1.0), lambda _: None)
    assert irat.status()["driven"] > 0
    assert irat.status()["moving"] is False
    ends = [record["end"] for record in journal(irat, "rest")]
    assert len(ends) == irat.count("motion"), "one motion; more on a machine that stalls"
    assert set(ends[:-1]) <= {"silence", "done"}, "it said nothing, or to rest, for a moment"
