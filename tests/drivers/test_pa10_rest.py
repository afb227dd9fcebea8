"""The museum arm's control loop pauses while nothing moves, and every line or push wakes it."""

import numpy as np
import pytest

from robots.kit.contract.find import spec_of
from tests.conftest import wait_for
from tests.drivers.pa10_wire import CLOCK, do, journal

pytestmark = pytest.mark.timed

REST_S = 20.0


def steps(shared):
    return shared.status()["steps"]


def rests(shared):
    before = steps(shared)
    CLOCK.sleep(0.2)
    return steps(shared) == before


def test_a_scene_at_rest_takes_no_steps_and_a_motion_begins_at_once(arm, shared):
    do(arm, "ready")
    wait_for(lambda: rests(shared), REST_S, "rest")
    before, late = steps(shared), shared.status()["worst_error"]
    asked = np.radians([20, 25, 75, 0, 80, 0]).tolist()
    do(arm, "joints", **dict(zip(spec_of("pa10").joints[:6], asked, strict=True)))
    assert np.allclose(arm.state().joints[:6], asked, atol=2e-3)
    assert steps(shared) > before + 100
    assert shared.status()["worst_error"] <= max(late, 0.02), "time did not jump where it had stood still"


def test_the_gripper_closes_out_of_rest(arm, shared):
    wait_for(lambda: rests(shared), REST_S, "rest")
    opening = arm.state().joints[6]
    do(arm, "gripper", closed=1.0 if opening > 0.03 else 0.0)
    assert abs(arm.state().joints[6] - opening) > 0.01


def test_a_push_is_felt_out_of_rest(terminal, shared):
    assert terminal.ask("j 160 -40 -40 0 -30 0 1").startswith("ok")
    assert terminal.ask("W") == "a"
    wait_for(lambda: rests(shared), REST_S, "rest")
    shared.fault("disturb", 900.0)
    wait_for(lambda: terminal.ask("w") == "e", 10, "the range error")
    shared.clear()
    assert "S1" in journal(shared, "range_error")[-1]["why"]
    wait_for(lambda: rests(shared), REST_S, "rest, pushed to where it is")
