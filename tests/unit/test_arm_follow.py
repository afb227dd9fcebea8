"""The tool follows a hand: it comes where the hand is, never faster than it may, and a hand that jumps is lost."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from robots.kit.arms.follow import GAIN, HAND, JUMP_M, THERE_M, Follower, HandLost
from robots.kit.contract.errors import BadRequest

NAMES = [argument.name for argument in HAND]
STEP_S = 0.1
turns = st.tuples(*[st.floats(-1, 1)] * 3)
poses = st.builds(
    lambda turn, at: pose(Rotation.from_rotvec(turn).as_matrix(), at), turns, st.tuples(*[st.floats(-0.6, 0.6)] * 3)
)


def pose(turn, at):
    made = np.eye(4)
    made[:3, :3], made[:3, 3] = turn, at
    return made


def hand(*values):
    return dict(zip(NAMES, (*values, *(0.0,) * (6 - len(values))), strict=True))


def moved(tool, twist, seconds):
    return pose(Rotation.from_rotvec(twist[3:] * seconds).as_matrix() @ tool[:3, :3], tool[:3, 3] + twist[:3] * seconds)


@given(poses, st.tuples(*[st.floats(-0.05, 0.05)] * 3), st.tuples(*[st.floats(-0.4, 0.4)] * 3))
def test_it_comes_where_the_hand_is_and_rests_there(begin, way, turn):
    follower, tool = Follower(begin, 0.15, 0.6), begin
    for _ in range(60):
        twist = follower.twist(tool, hand(*way, *turn))
        assert np.linalg.norm(twist[:3]) <= 0.15 + 1e-12
        assert np.linalg.norm(twist[3:]) <= 0.6 + 1e-12
        tool = moved(tool, twist, STEP_S)
    assert np.linalg.norm(tool[:3, 3] - begin[:3, 3] - way) <= THERE_M
    wanted = Rotation.from_rotvec(turn).as_matrix() @ begin[:3, :3]
    assert np.abs(tool[:3, :3] - wanted).max() < 1e-3
    assert not follower.twist(tool, hand(*way, *turn))[:3].any()


@given(poses, st.floats(0, 0.099), st.floats(0.101, 0.9))
def test_a_hand_that_jumps_is_lost_and_one_that_is_quick_is_not(begin, quick, jump):
    follower = Follower(begin, 0.15, 0.6)
    follower.twist(begin, hand(0.0, quick))
    with pytest.raises(HandLost, match=r"jumped by \d+ mm"):
        follower.twist(begin, hand(0.0, quick + jump))
    with pytest.raises(HandLost):
        Follower(begin, 0.15, 0.6).twist(begin, hand(0, 0, 0, 0, 0, 0.9))


def test_a_hand_that_takes_the_tool_again_ten_thousand_times_makes_no_jump():
    """Each time the hand is somewhere else; the tool begins at rest, and goes on from where it is."""
    dice, tool = np.random.default_rng(1), pose(np.eye(3), (0.5, 0.0, 0.3))
    for _ in range(10_000):
        follower = Follower(tool, 0.15, 0.6)
        assert not follower.twist(tool, hand()).any()
        way = dice.uniform(-0.02, 0.02, 3)
        step = moved(tool, follower.twist(tool, hand(*way)), STEP_S)
        assert np.linalg.norm(step[:3, 3] - tool[:3, 3]) <= min(0.15, GAIN * np.linalg.norm(way)) * STEP_S + 1e-12
        tool = pose(step[:3, :3], np.clip(step[:3, 3], -1, 1))


@pytest.mark.parametrize("value", [float("nan"), float("inf"), "1", None, True, 10**400])
def test_a_value_that_is_no_number_is_refused(value):
    with pytest.raises(BadRequest):
        Follower(np.eye(4), 0.15, 0.6).twist(np.eye(4), hand() | {"dx": value})


def test_a_hand_of_one_metre_a_second_is_no_jump():
    """A keep-alive ten times a second allows a hand of one metre a second."""
    assert JUMP_M / STEP_S >= 1.0


def test_the_gripper_is_told_each_wish_once_and_nothing_by_itself():
    follower = Follower(np.eye(4), 0.15, 0.6)
    wishes = [{}, {"closed": 1.0}, {"closed": 1.0}, {}, {"closed": 1.0}, {"closed": 0.4}, {"closed": 0.0}]
    assert [follower.grip(hand() | wish) for wish in wishes] == [None, True, None, None, None, False, None]
    for bad in (float("nan"), "1", None, True):
        with pytest.raises(BadRequest):
            follower.grip({"closed": bad})
