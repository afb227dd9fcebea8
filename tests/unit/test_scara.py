from math import hypot, isclose, pi, radians

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from robots.kit.description import load
from robots.kit.drivers.mercury.scara import OutOfReach, scara, wrap

D = load("mercury")
ARM = scara(D)


@given(st.floats(*D["sand"]["x"]), st.floats(*D["sand"]["y"]), st.floats(0, 0.075), st.floats(-0.3, 0.3))
def test_inverse_then_forward_returns_every_pose_on_the_sand(x, y, z, theta):
    q = ARM.inverse(x, y, z, theta)
    assert ARM.broken_limit(q) is None
    for got, wanted in zip(ARM.forward(q), (x, y, z, theta), strict=True):
        assert isclose(got, wanted, abs_tol=1e-9)


@given(st.floats(0, radians(200)), st.floats(0.01, radians(160)), st.floats(0, 0.075), st.floats(-3, 3))
def test_forward_then_inverse_finds_the_joints_again(q1, q2, q3, q4):
    found = ARM.branches(*ARM.forward((q1, q2, q3, q4)))
    near = [b for b in found if abs(wrap(b[0] - q1)) < 1e-6 and abs(wrap(b[1] - q2)) < 1e-6]
    assert near
    assert abs(wrap(near[0][3] - q4)) < 1e-6


@given(st.floats(-2, 2), st.floats(-2, 2))
def test_outside_the_annulus_is_refused_with_the_radius(x, y):
    assume(not ARM.inner_radius - 1e-6 <= hypot(x, y) <= ARM.outer_radius + 1e-6)
    with pytest.raises(OutOfReach):
        ARM.inverse(x, y, 0.0, 0.0)


def test_both_elbow_branches_reach_the_same_point():
    found = ARM.branches(0.1, 0.42, 0.0, 0.0)
    assert len(found) == 2
    assert {round(b[1], 6) for b in found} == {round(found[0][1], 6), round(-found[0][1], 6)}
    for branch in found:
        assert hypot(ARM.forward(branch)[0] - 0.1, ARM.forward(branch)[1] - 0.42) < 1e-12


def test_the_broken_limit_is_named():
    with pytest.raises(OutOfReach, match="q3 would be 0.200 m"):
        ARM.inverse(0.0, 0.42, 0.2, 0.0)


@given(st.floats(-100, 100))
def test_wrap_stays_in_one_turn(a):
    w = wrap(a)
    assert -pi < w <= pi + 1e-12
    assert isclose((a - w) / (2 * pi), round((a - w) / (2 * pi)), abs_tol=1e-9)
