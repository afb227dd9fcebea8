"""Compact states: what is read is what was written, to half a step; nothing else is read as a state."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from robots.kit.arms.described import chain
from robots.kit.contract.channels import Scalar, Scale
from robots.kit.contract.compact import CLOCK, Layout
from robots.kit.contract.session import RobotState
from robots.kit.contract.spec import Spec
from robots.kit.drivers.irat.spec import spec as irat
from robots.kit.drivers.mercury.spec import spec as mercury
from robots.kit.drivers.pa10.spec import spec as pa10

WORDS = st.text(max_size=12)


@st.composite
def scales(draw):
    low = draw(st.floats(-1e6, 1e6))
    steps = draw(st.integers(1, 2**32 - 4))
    step = draw(st.floats(1e-6, 1e3))
    try:
        return Scale(low, low + steps * step, step)
    except ValueError:
        assume(False)


@st.composite
def layouts(draw):
    joints = tuple(draw(st.lists(scales(), max_size=8)))
    values = tuple((f"v{n}", scale) for n, scale in enumerate(draw(st.lists(scales(), max_size=8))))
    return Layout(joints, values, tuple(draw(st.lists(WORDS, max_size=9, unique=True))))


@given(layouts(), st.data())
def test_what_is_written_is_read_to_half_a_step(layout, data):
    numbers = [
        data.draw(st.just(math.nan) | st.floats(scale.low, scale.high, allow_nan=False)) for scale in layout.scales
    ]
    at_ms = data.draw(st.integers(0, 2**50))
    near_ms = at_ms + data.draw(st.integers(-CLOCK // 2, CLOCK // 2 - 1))
    moving, stopped = data.draw(st.booleans()), data.draw(st.booleans())
    mode = data.draw(st.sampled_from(layout.modes) | WORDS if layout.modes else WORDS)
    count = len(layout.joints)
    state = RobotState(0.0, tuple(numbers[:count]), (), moving, True, mode=mode)
    told = {name: number for (name, _), number in zip(layout.values, numbers[count:], strict=True)}
    packet = layout.encode(at_ms, state, stopped, told)
    read, latched = layout.decode(packet, near_ms)
    assert len(packet) == layout.size + (0 if mode in layout.modes else len(mode.encode()))
    assert (round(read.at * 1000), read.moving, latched, read.mode) == (at_ms, moving, stopped, mode)
    found = [*read.joints, *(read.values.get(name, math.nan) for name, _ in layout.values)]
    for scale, wanted, number in zip(layout.scales, numbers, found, strict=True):
        if math.isnan(wanted):
            assert math.isnan(number)
        else:
            assert abs(number - wanted) <= scale.step / 2 * (1 + 1e-6) + 1e-9 * max(1, abs(wanted))


@given(layouts(), st.binary(max_size=60), st.integers(0, 2**50), st.booleans())
def test_any_bytes_are_a_state_or_are_refused(layout, data, near_ms, marked):
    if marked:
        data = bytes([layout.mark]) + data
    try:
        read, _ = layout.decode(data, near_ms)
    except ValueError:
        return
    for scale, joint in zip(layout.joints, read.joints, strict=True):
        assert math.isnan(joint) or scale.low - scale.step <= joint <= scale.high + scale.step * 1.001


@given(scales(), st.floats())
def test_a_number_outside_its_scale_is_never_told_as_one_inside(scale, number):
    code = scale.code(number)
    if not math.isfinite(number):
        assert math.isnan(scale.number(code))
    elif number < scale.low - scale.step or number > scale.high + scale.step:
        assert code is None


@pytest.mark.parametrize(
    ("low", "high", "step"),
    [(0, 1, 0), (0, 1, -1), (1, 1, 0.1), (2, 1, 0.1), (0, 1, 1e-12), (0, math.inf, 1), (math.nan, 1, 1)],
)
def test_what_is_no_scale_is_refused(low, high, step):
    with pytest.raises(ValueError, match=r"scale"):
        Scale(low, high, step)


def test_a_spec_names_scales_only_for_what_it_tells_and_each_word_once():
    with pytest.raises(ValueError, match="has a scale for 'q9'"):
        Spec("R", (), joints=("q1",), scales={"q9": Scale(0, 1, 0.1)})
    with pytest.raises(ValueError, match="the word 'on' twice"):
        Spec("R", (), modes=("on", "on"))


def test_a_robot_without_all_its_scales_has_no_layout():
    half = Spec("R", (), joints=("q1",), channels=(Scalar("heat", "C", 0, 90),), scales={"q1": Scale(0, 1, 0.1)})
    assert Layout.of(half) is None


def test_a_state_with_other_joints_is_told_in_full():
    layout = Layout.of(mercury())
    assert layout.encode(0, RobotState(0.0, (), (), False, True), False, {}) is None


def test_an_arm_takes_at_most_twenty_bytes_and_each_layout_has_its_mark():
    found = {name: Layout.of(spec) for name, spec in (("pa10", pa10()), ("mercury", mercury()), ("irat", irat()))}
    assert found["pa10"].size <= 20
    assert found["mercury"].size <= 20
    assert len({layout.mark for layout in found.values()}) == 3


def test_the_tool_is_told_to_a_twentieth_of_a_millimetre_and_of_a_degree():
    arm, layout, rng = chain("pa10"), Layout.of(pa10()), np.random.default_rng(1)
    low, high = np.array([j.low for j in arm.joints]), np.array([j.high for j in arm.joints])
    far = turned = 0.0
    for q in rng.uniform(low, high, (2000, len(low))):
        packet = layout.encode(0, RobotState(0.0, (*q, 0.02), (), False, True, mode="NO CTRL"), False, {})
        read, _ = layout.decode(packet, 0)
        wanted, found = arm.frames(q)[-1], arm.frames(np.array(read.joints[:-1]))[-1]
        far = max(far, np.linalg.norm(wanted[:3, 3] - found[:3, 3]) * 1000)
        cosine = (np.trace(wanted[:3, :3].T @ found[:3, :3]) - 1) / 2
        turned = max(turned, math.degrees(math.acos(min(1.0, cosine))))
    assert far <= 0.05
    assert turned <= 0.05
