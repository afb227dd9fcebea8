"""Kinematics, paths and forbidden boxes of an arm with six axes, on the PA10's description."""

from functools import cache
from importlib.resources import files

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robots.kit.arms import segments
from robots.kit.arms.budget import MOST, Budget
from robots.kit.arms.chain import Chain
from robots.kit.arms.inverse import Inverse, OutOfReach
from robots.kit.arms.path import Cubic, Limits, TooFast, brake_path, joint_path
from robots.kit.arms.planner import Planner, Refused
from robots.kit.arms.pose import EULER, RPY, matrix, numbers
from robots.kit.arms.singular import singularity
from robots.kit.arms.straight import line_path
from robots.kit.arms.zones import Box, Limb, Zones
from tests.conftest import at_length

many = settings(max_examples=200, deadline=None)
share = st.floats(0, 1)
joints = st.lists(share, min_size=6, max_size=6)


@cache
def arm():
    return Chain.from_urdf(files("robots.kit.drivers.pa10").joinpath("model.urdf").read_text(), "tip")


@cache
def inverse():
    return Inverse(arm())


def at(shares):
    return arm().low + np.array(shares) * (arm().high - arm().low)


def off(a, b):
    return float(np.linalg.norm(a[:3, 3] - b[:3, 3])), float(np.linalg.norm(a[:3, :3] - b[:3, :3]))


def test_the_default_position_is_upright():
    pose = arm().forward(np.zeros(6))
    assert pose[:3, 3] == pytest.approx([0, 0, 0.317 + 0.450 + 0.480 + 0.070 + 0.115])
    assert arm().names == ("S1", "S2", "E1", "E2", "W1", "W2")


@many
@given(joints)
def test_every_branch_reaches_the_pose_and_the_joints_themselves_are_one(shares):
    q = at(shares)
    pose = arm().forward(q)
    found = inverse().branches(pose)
    assert found
    for one in found:
        metres, turn = off(arm().forward(one), pose)
        assert metres < 1e-6
        assert turn < 1e-6
    if not singularity(arm(), q, 1e-3):
        assert min(np.abs((one - q + np.pi) % (2 * np.pi) - np.pi).max() for one in found) < 1e-5


@many
@given(joints, joints)
def test_the_nearest_branch_is_inside_the_limits_and_none_is_nearer(shares, near):
    pose, near = arm().forward(at(shares)), at(near)
    chosen = inverse().nearest(pose, near)
    assert arm().broken_limit(chosen) == ""
    cost = np.max(np.abs(chosen - near) / arm().velocity)
    assert all(np.max(np.abs(q - near) / arm().velocity) >= cost - 1e-12 for q in inverse().inside(pose))


def test_a_singular_wrist_is_shared_out_inside_the_limits():
    """With W1 at zero only the sum of E2 and W2 counts; the closed form's share of it may be out of reach."""
    q = at([0.0, 0.0, 0.0, 0.0, 0.5, 0.0])
    assert q[4] == 0
    pose = arm().forward(q)
    chosen = inverse().nearest(pose, np.zeros(6))
    assert arm().broken_limit(chosen) == ""
    metres, turn = off(arm().forward(chosen), pose)
    assert (metres < 1e-6, turn < 1e-6) == (True, True)


@pytest.mark.parametrize("angles", [RPY, EULER])
@many
@given(st.lists(st.floats(-3.1, 3.1), min_size=6, max_size=6))
def test_angles_there_and_back(angles, six):
    pose = matrix(tuple(six), angles)
    metres, turn = off(matrix(numbers(pose, angles), angles), pose)
    assert metres < 1e-12
    assert turn < 1e-6  # where two axes all but coincide, half of the digits are lost


def test_out_of_reach_says_how_far_and_a_limit_is_named():
    pose = arm().forward(np.zeros(6))
    pose[2, 3] += 0.1
    with pytest.raises(OutOfReach, match="0.100 m away"):
        inverse().inside(pose)
    beyond = np.array([0.0, 1.5882, -0.3, 0.1, 0.4, 0.0])  # S2 past its soft limit
    with pytest.raises(OutOfReach, match=r"joint \w+ would be at .*°, outside"):
        inverse().inside(arm().forward(np.array([3.05, 1.58, 0.1, 0.0, 0.1, 0.0])))
    assert "S2" in arm().broken_limit(beyond)


def test_a_singular_pose_names_its_joints():
    text = singularity(arm(), np.array([0.3, 0.5, 0.7, 0.4, 0.0, 0.2]))
    assert "E2" in text
    assert "W2" in text
    assert singularity(arm(), np.array([0.3, 0.5, 0.7, 0.4, 0.6, 0.2])) == ""


@many
@given(joints, joints, st.floats(0.05, 1.0))
def test_a_path_begins_as_sampled_ends_at_rest_and_keeps_the_limits(a, b, scale):
    limits = Limits.of(arm())
    start, target = at(a), at(b)
    path = joint_path(start, np.zeros(6), target, limits, scale)
    times = np.linspace(0, path.seconds, 200)
    q, v, hard = (np.array(rows) for rows in zip(*(path.at(t) for t in times), strict=True))
    assert np.allclose(path.sample(times), q)
    assert np.all(np.abs(v) <= path.fastest() + 1e-9)
    assert np.allclose(q[0], start)
    assert np.allclose(path.at(path.seconds)[0], target)
    assert np.allclose(path.at(path.seconds + 1)[1], 0)
    assert np.all(np.abs(v) <= limits.velocity * scale * (1 + 1e-6) + 1e-9)
    assert np.all(np.abs(hard) <= limits.acceleration * (1 + 1e-6))
    assert np.all(q >= limits.low - 1e-9)
    assert np.all(q <= limits.high + 1e-9)


@many
@given(joints, joints, joints, st.lists(st.floats(-1, 1), min_size=6, max_size=6), st.floats(0.2, 1.0))
def test_a_target_in_motion_blends_from_the_sampled_state_or_brakes_first(a, b, c, pace, scale):
    limits = Limits.of(arm())
    start, velocity = at(a), np.array(pace) * limits.velocity
    try:
        path = joint_path(start, velocity, at(b), limits, scale)
    except TooFast:
        path = brake_path(start, velocity, limits)
        assert np.all(path.hardest() <= limits.acceleration * (1 + 1e-9))
    q, v, _ = path.at(0.0)
    assert np.allclose(q, start)
    assert np.allclose(v, velocity)
    assert np.all(path.fastest() <= np.maximum(np.abs(velocity), limits.velocity * scale) * (1 + 1e-6))
    assert np.allclose(path.at(path.seconds)[1], 0)


@settings(max_examples=10, deadline=None)
@given(st.floats(0.45, 0.65), st.floats(-0.3, 0.3), st.floats(0.15, 0.4), st.floats(0.35, 0.6), st.floats(-0.3, 0.3), st.floats(0.15, 0.4))  # fmt: skip
def test_a_straight_line_is_straight_and_keeps_the_limits(x, y, z, u, v, w):
    limits = Limits.of(arm())
    start = inverse().nearest(matrix((x, y, z, np.pi, 0, 0)), np.array([0, 0.6, 1.2, 0, 1.2, 0]))
    target = matrix((u, v, w, np.pi, 0, 0))
    try:
        path = line_path(inverse(), start, target, limits, 0.5, Budget(MOST))
    except OutOfReach as error:
        assert "straight line" in str(error)
        return
    begin, end = np.array([x, y, z]), np.array([u, v, w])
    times = np.linspace(0, path.seconds, 40)
    assert np.allclose(path.sample(times), [path.at(t)[0] for t in times])
    for t in times:
        q, speed, _ = path.at(t)
        assert np.all(np.abs(speed) <= path.fastest() * (1 + 1e-9))
        tip = arm().forward(q)[:3, 3]
        along = np.clip(np.dot(tip - begin, end - begin) / max(np.dot(end - begin, end - begin), 1e-12), 0, 1)
        assert np.linalg.norm(tip - begin - along * (end - begin)) < 0.0005
        assert np.all(np.abs(speed) <= limits.velocity * 0.5 * 1.02)
    assert np.linalg.norm(arm().forward(path.at(path.seconds)[0])[:3, 3] - end) < 1e-6


TABLE = Box("the table", (-2, -2, -1), (2, 2, 0))
PILLAR = Box("the pillar", (0.3, -0.05, -1), (0.4, 0.05, 1.0))
LIMBS = (
    Limb("elbow", 1, (0, 0, 0.05), (0, 0, 0.45), 0.08),
    Limb("wrist", 2, (0, 0, 0.0), (0, 0, 0.5), 0.07),
    Limb("tool", 5, (0, 0, -0.05), (0, 0, 0.115), 0.05),
)


def segment_to_box(a, b, box, steps=4000):
    t = np.linspace(0, 1, steps)[:, None]
    points = a + t * (b - a)
    gap = np.maximum(0, np.maximum(np.array(box.low) - points, points - np.array(box.high)))
    return np.sqrt((gap**2).sum(axis=1)).min()


@many
@given(joints)
def test_distances_agree_with_a_fine_grid(shares):
    q = at(shares)
    zones = Zones(arm(), LIMBS, (TABLE, PILLAR))
    frames = arm().frames(q)
    expected = []
    for limb in LIMBS:
        ends = [(frames[limb.joint] @ np.array([*p, 1]))[:3] for p in (limb.begin, limb.end)]
        expected += [segment_to_box(*ends, box) - limb.radius for box in (TABLE, PILLAR)]
    assert zones.distances(q) == pytest.approx(expected, abs=2e-4)


@settings(max_examples=100, deadline=None)
@given(joints, joints)
def test_a_sweep_misses_nothing_that_a_fine_grid_sees(a, b):
    zones = Zones(arm(), LIMBS, (TABLE, PILLAR))
    start = at(a)
    if np.any(zones.distances(start) < 0):
        return
    path = joint_path(start, np.zeros(6), at(b), Limits.of(arm()), 1.0)
    found = zones.swept(path)
    least = zones.distances(path.sample(np.linspace(0, path.seconds, 400))).min()
    if found is None:
        assert least >= -1e-4
    else:
        t, touch = found
        assert zones.distances(path.at(t)[0]).min() < 0
        assert touch.box in ("the table", "the pillar")


def test_what_is_inside_may_only_move_away():
    zones = Zones(arm(), LIMBS, (TABLE,))
    low = np.array([0, 1.05, 1.3, 0, 0.7, 0])
    assert zones.distances(low).min() < 0
    out = joint_path(low, np.zeros(6), np.array([0, 0.5, 1.0, 0, 0.7, 0]), Limits.of(arm()), 0.5)
    assert zones.swept(out) is None
    deeper = joint_path(low, np.zeros(6), np.array([0, 1.2, 1.3, 0, 0.7, 0]), Limits.of(arm()), 0.5)
    assert zones.swept(deeper) is not None


CLEARANCE_M = 0.01


@settings(max_examples=100, deadline=None)
@given(joints, joints)
def test_what_is_planned_keeps_its_clearance(a, b):
    zones, limits = Zones(arm(), LIMBS, (TABLE, PILLAR)), Limits.of(arm())
    planner, rest = Planner(arm(), zones, limits, CLEARANCE_M), np.zeros(6)
    start, target = at(a), at(b)
    if np.any(zones.distances(start) < CLEARANCE_M):
        return
    try:
        path = planner.joints(target, start, rest, 1.0).path
    except Refused:
        path = joint_path(start, rest, target, limits, 1.0)
        kept = zones.distances(path.sample(np.linspace(0, path.seconds, 2000))).min()
        assert kept < CLEARANCE_M + 1e-3  # nothing is refused that would have stayed away
        return
    assert zones.distances(path.sample(np.linspace(0, path.seconds, 400))).min() > CLEARANCE_M - 1e-4


def test_the_clearance_alone_refuses_what_the_boxes_would_allow_and_lets_out_who_is_in_it():
    zones, limits, rest = Zones(arm(), LIMBS, (TABLE,)), Limits.of(arm()), np.zeros(6)
    low, high = np.array([0, 0.5, 1.0, 0, 0.7, 0]), np.array([0, 1.0, 1.3, 0, 0.7, 0])
    for _ in range(50):  # as near to the table as 5 mm
        middle = (low + high) / 2
        low, high = (low, middle) if zones.distances(middle).min() < CLEARANCE_M / 2 else (middle, high)
    away = np.array([0, 0.5, 1.0, 0, 0.7, 0])
    Planner(arm(), zones, limits).joints(low, away, rest, 0.5)
    careful = Planner(arm(), zones, limits, CLEARANCE_M)
    with pytest.raises(Refused, match="the table"):
        careful.joints(low, away, rest, 0.5)
    careful.joints(away, low, rest, 0.5)
    with pytest.raises(Refused, match="the table"):
        careful.joints(low + 0.01, low, rest, 0.5)


def test_a_description_that_is_wrong_is_named():
    text = files("robots.kit.drivers.pa10").joinpath("model.urdf").read_text()
    with pytest.raises(ValueError, match="no link 'nose'"):
        Chain.from_urdf(text, "nose")
    with pytest.raises(ValueError, match="prismatic"):
        Chain.from_urdf(text, "left_pad")


def test_a_cubic_that_is_over_rests():
    path = Cubic.between(np.zeros(1), np.ones(1), np.ones(1), 2.0)
    q, v, a = path.at(5.0)
    assert (q[0], v[0], a[0]) == (1.0, 0.0, 0.0)


@pytest.mark.parametrize("poses", [2000, at_length(10_000)])
def test_forward_and_inverse_agree_with_mujoco_over_thousands_of_poses(poses):
    """MuJoCo reads the same description by its own means: an independent judge."""
    import mujoco

    spec = mujoco.MjSpec.from_string(files("robots.kit.drivers.pa10").joinpath("model.urdf").read_text())
    spec.compiler.fusestatic = False
    model = spec.compile()
    data = mujoco.MjData(model)
    tip = model.body("tip").id
    places = [model.joint(name).qposadr[0] for name in arm().names]

    def judged(q):
        data.qpos[places] = q
        mujoco.mj_kinematics(model, data)
        pose = np.eye(4)
        pose[:3, 3], pose[:3, :3] = data.xpos[tip], data.xmat[tip].reshape(3, 3)
        return pose

    dice = np.random.default_rng(2004)
    worst = [0.0, 0.0]
    branches = 0
    for _ in range(poses):
        asked = judged(dice.uniform(arm().low, arm().high))
        found = inverse().branches(asked)
        branches += len(found)
        for q in (found[0], found[-1]):
            metres, turn = off(judged(q), asked)
            worst = [max(worst[0], metres), max(worst[1], turn)]
    assert worst[0] < 1e-6
    assert worst[1] < 1e-6
    assert branches > 7 * poses


@many
@given(joints, joints)
def test_a_rough_look_at_the_boxes_is_never_too_hopeful(a, b):
    zones, q = Zones(arm(), LIMBS, (TABLE, PILLAR)), np.array([at(a), at(b)])
    begin, end = zones._segments(q)
    rough = segments.at_least(begin, end, zones._low, zones._high)
    assert np.all(rough <= segments.exactly(begin, end, zones._low, zones._high) + 1e-12)
    for one in q:
        assert np.allclose(zones.distances(q)[list(map(tuple, q)).index(tuple(one))], zones.distances(one))
        if zones.clear(one):
            assert zones.distances(one).min() >= 0


@many
@given(joints, joints, st.floats(0.0, 1.0))
def test_what_is_still_clear_without_a_look_is_clear(a, b, share):
    zones = Zones(arm(), LIMBS, (TABLE, PILLAR))
    there, moved = at(a), share * (at(b) - at(a))
    before, after = zones.distances(there), zones.distances(there + moved)
    by = np.abs(moved)
    if zones.still_clear(before, by):
        assert after.min() > 0
    assert not zones.still_clear(np.zeros_like(before), by)
    assert not zones.still_clear(before, by * np.nan)
    assert zones.still_clear(before, by * 0) == (before.min() > 0)
