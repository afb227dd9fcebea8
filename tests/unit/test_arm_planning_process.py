"""The museum arm's planner in a process of its own: the same answers, the same refusals, begun again when lost; its cost."""

import os
import signal
import statistics

import numpy as np
import pytest

from robots.kit.arms.described import posture
from robots.kit.arms.planner import Refused
from robots.kit.arms.zones import Box
from robots.kit.description import load
from robots.kit.drivers.pa10.courses import Courses
from robots.kit.drivers.pa10.protocol import parse, program
from simulators.pa10.planning import Planning
from tests.conftest import wait_for
from tests.waiting import CEILING_S

PLAN_S = 0.005  # of processor time, well within what the controller looks ahead
READY, STILL = posture(load("pa10"), "ready"), np.zeros(6)
VASE = Box("the vase", (0.4, 0.1, 0.0), (0.6, 0.3, 0.3))


@pytest.fixture(scope="module")
def planning():
    lost = []
    made = Planning(lambda event, **details: lost.append(event))
    made.lost = lost
    yield made
    made.close()


def test_what_is_planned_there_is_what_would_be_planned_here(planning):
    for line in ("j 30 10 60 0 50 0", "k 500 160 150 180 0 180", "l 500 100 200 180 0 180 0.3"):
        there, here = (made.plan(parse(line), READY, STILL) for made in (planning, Courses()))
        assert there.mode == here.mode
        assert np.array_equal(there.plan.target, here.plan.target)
        for t in np.linspace(0, here.plan.path.seconds, 20):
            assert np.array_equal(there.plan.path.at(t), here.plan.path.at(t))
    steps = program("g 1\nj 30 10 60 0 50 0\nd 2")
    assert planning.check(steps, READY) == Courses().check(steps, READY)


def test_refusals_come_over_in_their_own_words_and_boxes_are_known_there(planning):
    with pytest.raises(Refused, match="the end effector would enter the table") as error:
        planning.plan(parse("k 500 160 0 180 0 180"), READY, STILL)
    assert error.value.code == "box"
    planning.forbid((VASE,))
    with pytest.raises(Refused, match="the vase"):
        planning.plan(parse("k 500 160 150 180 0 180"), READY, STILL)
    planning.forbid(())
    planning.plan(parse("k 500 160 150 180 0 180"), READY, STILL)


def test_a_planner_that_was_killed_is_begun_again(planning):
    os.kill(planning.process.pid, signal.SIGKILL)
    planning.process.wait()
    assert planning.plan(parse("j 30 10 60 0 50 0"), READY, STILL).plan.path.seconds > 0
    assert planning.lost == ["planning_lost"]


def test_a_planner_that_does_not_answer_in_time_is_begun_again():
    def note(event, **details):
        lost.append(event)
        made.within_s = CEILING_S  # the new one may take its time

    lost, made = [], Planning(note)
    try:
        os.kill(made.process.pid, signal.SIGSTOP)
        made.within_s = 0.2
        assert made.plan(parse("j 30 10 60 0 50 0"), READY, STILL).plan.path.seconds > 0
        assert lost == ["planning_lost"]
    finally:
        made.close()


def test_it_ends_with_whoever_asks():
    made = Planning()
    made._line.close()
    wait_for(lambda: made.process.poll() is not None, 20, "the planner's end")
    made.close()


@pytest.mark.timed
def test_a_target_in_motion_is_planned_in_five_milliseconds_of_processor_time(stopwatch):
    courses, dice = Courses(), np.random.default_rng(6)
    full = courses.planner.limits.velocity
    took = []
    for _ in range(60):
        x, y, z = dice.uniform((350, -250, 120), (650, 250, 400))
        wrist = dice.uniform(-100, 100)
        target = parse(f"k {x:.1f} {y:.1f} {z:.1f} 180 0 {wrist:.1f}")
        velocity = dice.uniform(-0.3, 0.3, 6) * full
        begun = stopwatch.process_time()
        try:
            courses.plan(target, READY, velocity)
        except Refused:
            continue  # a refusal takes less time than a plan
        took.append(stopwatch.process_time() - begun)
    assert len(took) > 30
    assert statistics.median(took) < PLAN_S
