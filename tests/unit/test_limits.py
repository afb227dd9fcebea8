from math import hypot

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.kit.contract.errors import BadRequest, OutOfWorkspace
from robots.kit.contract.session import RobotState
from robots.kit.contract.values import check
from robots.kit.description import load
from robots.kit.drivers.mercury.checks import check_target
from robots.kit.drivers.mercury.scara import scara

D = load("mercury")


def at(z):
    return RobotState(0.0, (), (0.0, 0.42, z, 0.0), False, True)


wild = st.one_of(
    st.floats(allow_nan=True, allow_infinity=True), st.sampled_from([1e308, -1e308, 0.0, 0.42]), st.floats(-0.7, 0.7)
)


@given(wild, wild, st.one_of(wild, st.floats(-0.01, 0.09)))
def test_what_is_let_through_lies_inside_everything(x, y, z):
    try:
        q = check_target(D, x, y, z)
    except (BadRequest, OutOfWorkspace):
        return
    arm = scara(D)
    assert D["sand"]["x"][0] - 1e-5 <= x <= D["sand"]["x"][1] + 1e-5
    assert D["sand"]["y"][0] - 1e-5 <= y <= D["sand"]["y"][1] + 1e-5
    assert -1e-5 <= z <= 0.075 + 1e-5
    assert arm.inner_radius <= hypot(x, y) <= arm.outer_radius
    assert arm.broken_limit(q) is None


values = st.one_of(
    st.none(), st.booleans(), st.text(max_size=5), st.integers(), wild, st.lists(st.integers(), max_size=2)
)


@given(st.sampled_from(["move", "air", "speed", "up", "fly", ""]), st.dictionaries(st.sampled_from(["x", "y", "seconds", "speed", "z"]), values))  # fmt: skip
def test_any_values_at_all_are_refused_with_a_sentence_or_lie_inside(kind, args):
    try:
        check("mercury", kind, args, {}, at(0.0))
    except (BadRequest, OutOfWorkspace) as error:
        assert str(error).endswith(".")
        return
    if kind == "move":
        assert abs(args["x"]) <= 0.2401
        assert 0.2899 <= args["y"] <= 0.5501


@pytest.mark.parametrize(
    ("point", "words"),
    [
        ((0.0, 0.1), "from the shoulder"), ((0.0, 0.6), "off the sand"), ((0.3, 0.4), "off the sand"), ((5.0, 0.0), "reaches"),
    ],
)  # fmt: skip
def test_the_sentence_names_axis_value_and_limit(point, words):
    with pytest.raises(OutOfWorkspace, match=words):
        check_target(D, *point, 0.0)


def test_air_wants_the_arm_down():
    with pytest.raises(BadRequest, match="press Down first"):
        check("mercury", "air", {}, {}, at(0.05))
