"""The simulated arm's own limits: no joint passes one, at the ends of a motion or between them."""

from itertools import pairwise
from math import degrees, radians

from hypothesis import given
from hypothesis import strategies as st

from robots.kit.description import load
from simulators.mercury.arm import START, Pose
from simulators.mercury.workspace import Workspace

D = load("mercury")
SPACE = Workspace(D)
point = st.tuples(st.floats(*D["sand"]["x"]), st.floats(*D["sand"]["y"]), st.floats(0, 0.075))


def between(start, end, parts=200):
    pairs = list(zip(start.as_tuple(), end.as_tuple(), strict=True))
    return [Pose(*(a + (b - a) * i / parts for a, b in pairs)) for i in range(parts + 1)]


@given(st.lists(st.one_of(point, st.floats(-360, 360)), min_size=1, max_size=6))
def test_whatever_is_accepted_keeps_every_joint_inside_on_the_whole_way(asked):
    here = START
    for one in asked:
        end = SPACE.turn_end(here, radians(one)) if isinstance(one, float) else SPACE.line_end(here, *one)
        if end is None:
            continue
        joints = [SPACE.joints(p) for p in between(here, end)]
        assert not any(SPACE.passed(p) for p in between(here, end))
        steps = [abs(b[3] - a[3]) for a, b in pairwise(joints)]
        assert max(steps) < radians(10), "joint 4 jumps over its limit"
        here = end


@given(point)
def test_the_whole_sand_is_reached_with_the_camera_square(to):
    assert SPACE.line_end(START, *to) is not None


def test_a_way_that_would_turn_joint_4_past_its_limit_is_refused():
    left = SPACE.line_end(START, -0.23, 0.42, 0.075)
    q1, q2, _, _ = SPACE.joints(left)
    near = SPACE.turn_end(left, q1 + q2 + SPACE.arm.tool_angle + radians(170))
    assert abs(degrees(SPACE.joints(near)[3]) - 170) < 1e-6
    assert SPACE.line_end(near, 0.23, 0.42, 0.075) is None
    assert SPACE.line_end(near, -0.23, 0.42, 0.0) is not None


@given(st.lists(st.sampled_from([float("nan"), float("inf"), 1e308, -1e308, 0.0, 0.42, 5.0]), min_size=4, max_size=4))
def test_a_kept_pose_that_cannot_be_is_not_taken(values):
    taken = SPACE.tidy_pose(Pose(*values))
    assert taken is None or SPACE.passed(taken) is None
