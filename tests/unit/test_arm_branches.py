"""Which of an arm's answers is taken: the nearest over all branches and all whole turns inside the limits."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robots.kit.arms.described import chain, posture
from robots.kit.arms.inverse import FAR_S, NEAR_S, Inverse
from robots.kit.arms.pose import EULER, RPY, numbers
from robots.kit.arms.singular import singularity
from robots.kit.description import load
from robots.kit.drivers.pa10.protocol import parse
from robots.kit.drivers.pa10.units import pose_of, pose_request
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


def wrist(dice):
    """Return joints with W1 at zero: E2 and W2 turn about the same axis."""
    q = dice.uniform(ARM.low, ARM.high)
    q[4] = 0.0
    return q


def upright(dice):
    """Return joints of which S1, E2 and W2 all turn about the same axis; the elbow may be bent back over the base."""
    q = dice.uniform(ARM.low, ARM.high)
    q[[1, 2, 4]] = 0.0
    return q


def over_the_base(dice):
    """Return joints whose wrist stands on the axis of S1, which the wrist's joints can make up for."""
    q = dice.uniform(ARM.low, ARM.high)
    q[2] = dice.choice([-1.0, 1.0]) * dice.uniform(1.2, 2.3)
    q[1] = np.arctan2(-0.48 * np.sin(q[2]), 0.45 + 0.48 * np.cos(q[2]))
    return q


KINDS = {"regular": lambda dice: dice.uniform(ARM.low, ARM.high)} | {
    f.__name__: f for f in (wrist, upright, over_the_base)
}
EACH_KIND = pytest.mark.parametrize("kind", KINDS)
POSES = pytest.mark.parametrize("poses", [60, at_length(3000)])


@EACH_KIND
def test_these_poses_are_what_they_are_called(kind):
    q = KINDS[kind](np.random.default_rng(3))
    assert bool(singularity(ARM, q)) == (kind != "regular")


@EACH_KIND
@POSES
@pytest.mark.parametrize("letter", "kK")
def test_staying_costs_nothing(kind, poses, letter):
    """The pose where the arm stands, as a line of the wire tells it and as the state does with its five decimals."""
    dice = np.random.default_rng(5)
    for _ in range(poses):
        q = KINDS[kind](dice)
        told = np.radians(np.round(np.degrees(q), 5))
        for here in (q, told):
            six = numbers(ARM.forward(here), EULER if letter == "K" else RPY)
            asked = pose_of(parse(pose_request(letter, six).encode().decode()))
            chosen = INVERSE.nearest(asked, q)
            assert cost(chosen, q) < 1e-5, (q, chosen)
            assert np.abs(ARM.forward(chosen) - asked).max() < 2e-6


@EACH_KIND
@POSES
def test_no_share_of_the_joints_that_turn_against_each_other_is_nearer(kind, poses):
    """From near by and from anywhere: the joints of which the pose was made are one answer."""
    dice = np.random.default_rng(6)
    for number in range(poses):
        q = KINDS[kind](dice)
        if number % 2:
            near = np.clip(q + dice.normal(0, 0.05, 6), ARM.low, ARM.high)
        else:
            near = dice.uniform(ARM.low, ARM.high)
        if kind in ("upright", "over_the_base"):  # many lines, and a curve: only beside them is the nearest sought
            near = q + dice.normal(0, 1e-3, 6)
            if np.min([q - ARM.low, ARM.high - q]) < 0.02 or (kind == "over_the_base" and abs(q[4]) < 0.2):
                continue
        chosen = INVERSE.nearest(ARM.forward(q), near)
        assert ARM.broken_limit(chosen) == ""
        assert np.abs(ARM.forward(chosen) - ARM.forward(q)).max() < 1e-6
        assert cost(chosen, near) <= max(cost(q, near), FAR_S if kind == "over_the_base" else NEAR_S) + 1e-6, (
            q,
            near,
            chosen,
        )
