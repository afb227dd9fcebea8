"""Paths of motions in 48 bytes: what is read is what was written, nothing else is read, and an arm's are near enough."""

import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.kit.arms.described import posture
from robots.kit.arms.knots import FARTHEST_RAD, knots_of
from robots.kit.arms.motions import Motion
from robots.kit.arms.path import Cubic, brake_path
from robots.kit.arms.pose import numbers
from robots.kit.contract.compact import Layout
from robots.kit.contract.joint_path import MOST_JOINTS, MOST_KNOTS, JointPath
from robots.kit.contract.path_packet import (
    CLOCK,
    COMMANDS,
    FASTEST,
    LONGEST,
    BegunPath,
    bits_of,
    command_of,
    decode_path,
    encode_path,
    seconds_of,
)
from robots.kit.description import load
from robots.kit.drivers.mercury.spec import spec as mercury
from robots.kit.drivers.pa10.checks import planner_for
from robots.kit.drivers.pa10.spec import spec as pa10
from tests.environment import ROOT
from tests.unit.test_compact import layouts

VECTORS = json.loads((ROOT / "tests/vectors/path_packets.json").read_text())
ARM, PLANNER = load("pa10"), planner_for({})
DESTINATIONS = st.lists(st.floats(-0.8, 0.8), min_size=6, max_size=6)


@st.composite
def paths(draw):
    """Return a layout and a path of its first joints."""
    layout = draw(layouts().filter(lambda one: one.joints))
    count = draw(st.integers(1, len(layout.joints)))
    spans = [(s.low, s.steps * s.step) for s in layout.joints[:count]]
    row = st.tuples(*(st.floats(0.0, 1.0).map(lambda x, low=low, wide=wide: low + x * wide) for low, wide in spans))
    speed = st.tuples(*(st.floats(-FASTEST, FASTEST).map(lambda x, wide=wide: x * wide) for _, wide in spans))
    knots = tuple(draw(st.lists(row, min_size=2, max_size=MOST_KNOTS)))
    return layout, JointPath(knots, draw(st.integers(1, (1 << 20) - 1)) / 1000, draw(st.just(()) | speed))


@given(paths(), st.integers(0, 2**50), st.integers(0, 2**50), st.data())
def test_what_is_written_is_read_to_half_a_step_in_at_most_48_bytes(pair, command, began_ms, data):
    layout, path = pair
    packet = encode_path(layout, BegunPath(command, began_ms, path))
    joints, rows = len(path.knots[0]), len(path.knots) + bool(path.velocity)
    if packet is None:
        assert bits_of(rows, joints) < 8
        return
    assert len(packet) <= LONGEST
    near = began_ms + data.draw(st.integers(-CLOCK // 2, CLOCK // 2 - 1))
    read = decode_path(layout, packet, near)
    assert (read.command, read.began_ms) == (command % COMMANDS, began_ms)
    assert (command_of(packet), seconds_of(packet)) == (read.command, read.path.seconds)
    assert read.path.seconds == pytest.approx(path.seconds, abs=1e-9)
    most = (1 << bits_of(rows, joints)) - 1
    for index, scale in enumerate(layout.joints[:joints]):
        wide = scale.steps * scale.step
        slack = 1e-9 * max(abs(scale.low), wide, 1.0)
        for wanted, found in zip(path.knots, read.path.knots, strict=True):
            assert abs(wanted[index] - found[index]) <= 0.5 * wide / most + slack
        if path.velocity:
            assert abs(path.velocity[index] - read.path.velocity[index]) <= 2 * FASTEST * wide / most + slack


@given(layouts(), st.binary(max_size=60), st.integers(0, 2**50), st.booleans())
def test_any_bytes_are_a_path_or_are_refused(layout, data, near_ms, marked):
    if marked:
        data = bytes([6, layout.mark]) + data
    try:
        read = decode_path(layout, data, near_ms)
    except ValueError:
        return
    assert abs(read.began_ms - near_ms) <= CLOCK // 2
    for row in read.path.knots:
        for scale, joint in zip(layout.joints, row, strict=False):
            assert scale.low - scale.step <= joint <= scale.low + scale.steps * scale.step + scale.step


@pytest.mark.parametrize(
    "wrong",
    [
        {"knots": ((0.0,),)}, {"knots": ((0.0,),) * (MOST_KNOTS + 1)}, {"knots": ((0.0,), (0.0, 1.0))},
        {"knots": ((), ())}, {"knots": ((0.0,) * (MOST_JOINTS + 1),) * 2}, {"knots": ((0.0,), (math.nan,))},
        {"seconds": 0.0}, {"seconds": math.inf}, {"velocity": (0.0, 1.0)}, {"velocity": (math.inf,)},
    ],
)  # fmt: skip
def test_what_is_no_path_is_refused(wrong):
    with pytest.raises(ValueError, match="path"):
        JointPath(**({"knots": ((0.0,), (1.0,)), "seconds": 1.0} | wrong))


@pytest.mark.parametrize(
    "path",
    [
        JointPath(((9.9,), (0.0,)), 1.0), JointPath(((0.0,), (1.0,)), 1049.0), JointPath(((0.0,), (1.0,)), 1e-4),
        JointPath(((0.0,), (1.0,)), 1.0, (99.0,)), JointPath(((0.0,) * 8,) * 2, 1.0),
    ],
)  # fmt: skip
def test_a_path_that_the_scales_do_not_hold_has_no_packet(path):
    assert encode_path(Layout.of(pa10()), BegunPath(1, 0, path)) is None


@given(paths(), st.floats(0, 1))
def test_a_path_goes_through_its_knots_smoothly_from_its_velocity_to_rest(pair, share):
    _, path = pair
    step, scale = path.seconds / (len(path.knots) - 1), max(abs(v) for row in path.knots for v in row) or 1.0
    scale = max(scale, *(abs(v) * path.seconds for v in path.velocity), 1e-9)
    for n, row in enumerate(path.knots):
        assert path.at(n * step) == pytest.approx(row, abs=1e-6 * scale)
    assert path.at(-1.0) == pytest.approx(path.knots[0], abs=1e-6 * scale)
    assert path.at(path.seconds + 1) == pytest.approx(path.knots[-1], abs=1e-6 * scale)
    inner, h = share * path.seconds, 1e-4 * path.seconds
    before, here, after = (np.array(path.at(min(max(inner + d, 0.0), path.seconds))) for d in (-h, 0.0, h))
    assert np.abs(after - 2 * here + before).max() <= 0.05 * scale  # it never jumps


@given(DESTINATIONS, DESTINATIONS, st.lists(st.floats(-0.5, 0.5), min_size=6, max_size=6), st.floats(0.5, 9.0))
def test_two_knots_are_the_polynomial_of_the_arm(start, way, velocity, seconds):
    path = Cubic.between(np.array(start), np.array(velocity), np.array(start) + way, seconds)
    found = knots_of(path)
    for t in np.linspace(-0.1, seconds + 0.1, 23):
        assert found.at(float(t)) == pytest.approx(path.at(float(t))[0], abs=1e-9)
    brake = brake_path(np.array(start), np.array(velocity), PLANNER.planner.limits)
    assert knots_of(brake).at(brake.seconds / 3) == pytest.approx(brake.at(brake.seconds / 3)[0], abs=1e-9)


def test_the_tool_of_the_arm_is_foretold_to_ten_millimetres_and_two_degrees():
    """Motions of joints and straight lines, from rest and from a motion, as their packet is read."""
    rng, layout, chain = np.random.default_rng(7), Layout.of(pa10()), PLANNER.planner.chain
    ready, kinds = posture(ARM, "ready"), {False: 0, True: 0}
    for n in range(120):
        q = ready + rng.uniform(-0.7, 0.7, 6)
        straight, v = n % 2 == 1, (rng.uniform(-0.3, 0.3, 6) if n % 4 == 0 else np.zeros(6))
        pose = chain.forward(q).copy()
        pose[:3, 3] += rng.uniform(-0.3, 0.3, 3)
        motion = Motion(pose=numbers(pose), straight=straight) if straight else Motion(tuple(ready), scale=0.8)
        path = PLANNER.expected(motion, q, v)
        if path is None:
            continue
        kinds[straight] += 1
        packet = encode_path(layout, BegunPath(n, 0, knots_of(path)))
        found = decode_path(layout, packet, 0).path
        for t in np.linspace(0.0, path.seconds, 25):
            wanted, told = path.at(float(t))[0], np.array(found.at(float(t)))
            assert np.abs(wanted - told).max() <= FARTHEST_RAD
            off = np.linalg.norm(chain.forward(wanted)[:3, 3] - chain.forward(told)[:3, 3])
            assert off <= 0.01, f"{motion} is {1000 * off:.1f} mm off"
    assert min(kinds.values()) > 20


def test_a_motion_that_cannot_be_planned_is_not_foretold():
    rest, ready = np.zeros(6), posture(ARM, "ready")
    far = Motion(pose=(9.0, 0.0, 0.0, 0.0, 0.0, 0.0))
    assert PLANNER.expected(far, ready, rest) is None
    too_fast = np.full(6, 50.0)
    assert PLANNER.expected(Motion(tuple(ready)), ready, too_fast) is None


@pytest.mark.parametrize("one", VECTORS, ids=lambda one: one["what"])
def test_a_path_is_packed_as_the_browser_reads_it(one):
    layout = next(Layout.of(spec) for spec in (mercury(), pa10()) if spec.name == one["robot"])
    assert json.loads(json.dumps(layout.facts())) == one["layout"]
    path = JointPath(tuple(map(tuple, one["knots"])), one["seconds"], tuple(one["velocity"]))
    packet = encode_path(layout, BegunPath(one["command"], one["began_ms"], path))
    assert packet.hex() == one["hex"]
    read, wanted = decode_path(layout, packet, one["began_ms"]), one["read"]
    assert (read.command, read.path.seconds) == (wanted["command"], wanted["seconds"])
    assert np.array(read.path.knots) == pytest.approx(np.array(wanted["knots"]), abs=1e-12)
    assert read.path.velocity == pytest.approx(wanted["velocity"], abs=1e-12)
    for t, joints in one["at"]:
        assert read.path.at(t) == pytest.approx(joints, abs=1e-12)
