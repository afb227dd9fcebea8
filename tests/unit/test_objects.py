"""Packets of objects: what is read is what was written, as exactly as promised; deltas lead to the same as key packets."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from robots.kit.contract.objects import MOST, SIZE, Box, KnownObjects, Placed

BOX = Box((-1.5, -1.5, -0.2), (3.0, 3.0, 2.0))
FINITE = st.floats(allow_nan=False, allow_infinity=False, width=32)
PLACES = st.tuples(st.floats(-1.5, 1.5), st.floats(-1.5, 1.5), st.floats(-0.2, 1.8))
ROTATIONS = st.tuples(*[st.floats(-1, 1)] * 4).filter(lambda q: max(map(abs, q)) > 1e-6)
PLACED = st.builds(Placed, PLACES, ROTATIONS)
IN_TOOL = st.builds(Placed, st.tuples(*[st.floats(-0.25, 0.25)] * 3), ROTATIONS, st.just(True))
OBJECTS = st.dictionaries(st.integers(0, MOST - 1), PLACED | IN_TOOL, max_size=12)


def apart(a, b):
    """Return how far two places are apart (mm) and two rotations (degrees)."""
    turned = Rotation.from_quat(a.rotation).inv() * Rotation.from_quat(b.rotation)
    return math.dist(a.place, b.place) * 1000, math.degrees(turned.magnitude())


@given(st.integers(0, MOST - 1), PLACED)
def test_an_object_takes_12_bytes_and_is_told_exactly(number, placed):
    data = BOX.encode(number, placed)
    assert len(data) == SIZE
    again, found = BOX.decode(data)
    assert again == number
    far, turned = apart(placed, found)
    assert far <= 0.05
    assert turned <= 0.05


@given(st.integers(0, MOST - 1), IN_TOOL)
def test_an_object_that_is_held_takes_12_bytes_too_and_is_told_in_the_tool(number, placed):
    data = BOX.encode(number, placed)
    assert len(data) == SIZE
    again, found = BOX.decode(data)
    assert (again, found.held) == (number, True)
    far, turned = apart(placed, found)
    assert far <= 0.12
    assert turned <= 0.2


@given(st.lists(OBJECTS, min_size=1, max_size=8), st.data())
def test_deltas_lead_to_the_same_as_key_packets(states, data):
    writer, reader = KnownObjects(BOX), KnownObjects(BOX)
    for n, objects in enumerate(states):
        key = n == 0 or data.draw(st.booleans())
        packet = writer.key(objects) if key else writer.delta(objects)
        reader.take(packet, key)
        whole = KnownObjects(BOX).take(KnownObjects(BOX).key(objects), True)
        assert reader.objects == whole.objects
        assert writer.delta(objects) == b""


def test_a_delta_holds_what_has_moved_or_gone_and_nothing_else():
    told = KnownObjects(BOX)
    here = {n: Placed((n / 10, 0.0, 0.0)) for n in range(10)}
    assert len(told.key(here)) == 10 * SIZE
    assert len(told.delta({**here, 3: Placed((0.5, 0.5, 0.5))})) == SIZE
    assert len(told.delta({n: here[n] for n in range(9)})) == 2 * SIZE


@given(st.binary(max_size=60), st.booleans())
def test_any_bytes_are_objects_or_refused_as_a_whole(data, key):
    told = KnownObjects(BOX).take(KnownObjects(BOX).key({1: Placed((0.0, 0.0, 0.0))}), True)
    before = told.objects
    try:
        told.take(data, key)
    except ValueError:
        assert told.objects == before
    else:
        assert len(data) % SIZE == 0
        for placed in told.objects.values():
            assert np.isfinite([*placed.place, *placed.rotation]).all()


@given(st.tuples(FINITE, FINITE, FINITE))
def test_outside_the_box_an_object_is_told_at_its_edge(place):
    _, found = BOX.decode(BOX.encode(0, Placed(place)))
    ends = [(low, low + size) for low, size in zip(BOX.low, BOX.size, strict=True)]
    clipped = tuple(min(max(at, low), high) for at, (low, high) in zip(place, ends, strict=True))
    assert math.dist(found.place, clipped) * 1000 <= 0.05


@pytest.mark.parametrize(
    ("number", "placed", "said"),
    [
        (128, Placed((0, 0, 0)), "0 to 127"), (-1, None, "0 to 127"), (1, Placed((math.nan, 0, 0)), "not finite"),
        (1, Placed((0, 0, 0), (0, 0, 0, 0)), "rotation"), (1, Placed((0, 0, 0), (math.inf, 0, 0, 1)), "rotation"),
    ],
)  # fmt: skip
def test_what_cannot_be_told_is_refused(number, placed, said):
    with pytest.raises(ValueError, match=said):
        BOX.encode(number, placed)


@given(st.tuples(FINITE, FINITE, FINITE), st.tuples(FINITE, FINITE, FINITE))
def test_a_box_has_a_size(low, size):
    assume(min(size) <= 0)
    with pytest.raises(ValueError, match="size"):
        Box(low, size)
