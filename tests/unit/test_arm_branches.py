"""Which of an arm's answers is taken: the nearest over all branches and all whole turns inside the limits."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robots.description import load
from robots.motion.described import chain, posture
from robots.motion.inverse import Inverse
from robots.motion.singular import singularity
from tests.conftest import at_length

ARM = chain("pa10")
INVERSE = Inverse(ARM)
TURN = 2 * np.pi
NEAR_RAD = 0.15  # how near to a limit counts as near
ENDS = [(joint, side) for joint in range(6) for side in ("low", "high")]


def cost(q, near):
    return float(np.max(np.abs(q - near) / ARM.velocity))


def least(pose, near):
    """Return the least cost of all branches in all turns, tried one by one; None where none is inside."""
    found = []
    for branch in INVERSE.branches(pose):
        turns = [
            [v + k * TURN for k in (-1, 0, 1) if low - 1e-9 <= v + k * TURN <= high + 1e-9]
            for v, low, high in zip(branch, ARM.low, ARM.high, strict=True)
        ]
        found += [cost(np.array(q), near) for q in product(*turns)]
    return min(found, default=None)


def near_an_end(dice, joint, side):
    """Return joints of which one is near one of its limits."""
    q = dice.uniform(ARM.low, ARM.high)
    depth = dice.uniform(0, NEAR_RAD)
    q[joint] = ARM.low[joint] + depth if side == "low" else ARM.high[joint] - depth
    return q


def judge(q, near):
    pose = ARM.forward(q)
    chosen = INVERSE.nearest(pose, near)
    assert ARM.broken_limit(chosen) == ""
    assert np.abs(ARM.forward(chosen) - pose).max() < 1e-6
    wanted = least(pose, near)
    if wanted is not None and not singularity(ARM, q):
        assert cost(chosen, near) <= wanted + 1e-7
    return chosen


@pytest.mark.parametrize("poses", [100, at_length(10_000)])
@pytest.mark.parametrize(("joint", "side"), ENDS)
def test_no_branch_and_no_turn_of_it_is_nearer_than_the_one_taken(joint, side, poses):
    """From near the same limit, and from anywhere."""
    dice = np.random.default_rng((joint, side == "high"))
    for number in range(poses):
        q = near_an_end(dice, joint, side)
        near = near_an_end(dice, joint, side) if number % 2 else dice.uniform(ARM.low, ARM.high)
        judge(q, near)


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("way", [0.05, -0.05])
def test_a_small_step_stays_on_its_branch_where_w2_is_beyond_half_a_turn(sign, way):
    q = posture(load("pa10"), "ready")
    q[5] = sign * np.radians(195)
    target = q.copy()
    target[0] += way
    chosen = INVERSE.nearest(ARM.forward(target), q)
    assert chosen == pytest.approx(target, abs=1e-6)


@settings(max_examples=300, deadline=None)
@given(st.lists(st.floats(0, 1), min_size=6, max_size=6), st.lists(st.floats(-4, 4), min_size=6, max_size=6))
def test_the_start_may_be_outside_the_limits(shares, off):
    """An arm that was pushed away still gets the nearest answer inside."""
    judge(ARM.low + np.array(shares) * (ARM.high - ARM.low), np.array(off))


def test_all_answers_inside_are_told_each_turn_once():
    q = posture(load("pa10"), "ready")
    q[5] = np.radians(190)
    inside = np.array(INVERSE.inside(ARM.forward(q)))
    assert min(np.abs(inside - q).max(axis=1)) < 1e-6
    q[5] -= TURN
    assert min(np.abs(inside - q).max(axis=1)) < 1e-6
    apart = np.abs(inside[:, None] - inside[None]).max(axis=2) + np.eye(len(inside))
    assert apart.min() > 1e-6
