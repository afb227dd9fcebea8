"""A robot that rests sends one compact state a second; whatever changes is sent at once."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.kit.contract.compact import Layout
from robots.kit.contract.session import RobotState
from robots.kit.drivers.pa10.spec import spec
from workers.robot.beat import REST_S, STEPS, RestBeat

LAYOUT = Layout.of(spec())
REST = RobotState(0.0, (0.0, 0.4, -0.3, 1.0, 0.2, 0.0, 0.02), (), False, True, mode="NO CTRL")


def sent(states, every_s=0.1):
    """Return how many of these states are sent."""
    beat = RestBeat(LAYOUT)
    return sum(beat.due(state, stopped, {}, n * every_s) for n, (state, stopped) in enumerate(states))


def test_a_robot_that_rests_sends_one_a_second_and_one_that_moves_each():
    assert sent([(REST, False)] * 101) in (10, 11)
    assert sent([(replace(REST, moving=True), False)] * 100) == 100


@given(st.lists(st.floats(-0.5, 0.5), min_size=7, max_size=7))
def test_noise_of_a_step_is_rest(noise):
    moved = tuple(q + n * scale.step for q, n, scale in zip(REST.joints, noise, LAYOUT.joints, strict=True))
    beat = RestBeat(LAYOUT)
    assert beat.due(REST, False, {}, 0.0)
    assert not beat.due(replace(REST, joints=moved), False, {}, REST_S / 2)


@pytest.mark.parametrize("index", range(7))
def test_a_robot_that_drifts_is_told_as_soon_as_it_is_four_steps_away(index):
    beat, step = RestBeat(LAYOUT), LAYOUT.joints[index].step
    assert beat.due(REST, False, {}, 0.0)
    drifting = [
        replace(REST, joints=tuple(q + (n * step if i == index else 0.0) for i, q in enumerate(REST.joints)))
        for n in range(STEPS + 2)
    ]
    due = [beat.due(state, False, {}, 0.01 * n) for n, state in enumerate(drifting)]
    assert due == [False] * (STEPS + 1) + [True]


@pytest.mark.parametrize("change", [{"moving": True}, {"mode": "PROG EXEC"}, {"joints": REST.joints[:6]}])
def test_what_changes_is_told_at_once(change):
    beat = RestBeat(LAYOUT)
    assert beat.due(REST, False, {}, 0.0)
    assert beat.due(replace(REST, **change), False, {}, 0.01)
    assert beat.due(REST, True, {}, 0.02), "a stop is latched"
