"""When packets are sent: each of them once in each period, so that nobody waits longer than was said."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from portal.broadcast.packets import DATAGRAM, HEAD, PAYLOAD, TAG, UDP_IP
from portal.broadcast.schedule import least, polyharmonic
from portal.broadcast.timetable import SECOND, bytes_a_second, channels

sizes = st.lists(st.integers(1, 60_000), min_size=1, max_size=12)
slots = st.integers(SECOND // 5, 2 * SECOND)
joins = st.integers(0, 200 * SECOND)


@given(sizes, slots, st.integers(1, 6), joins)
def test_whoever_joins_at_any_moment_has_each_segment_whole_when_it_is_shown(sizes, slot, wait, joined):
    starts = [n * slot for n in range(len(sizes))]
    for one, start in zip(channels(sizes, starts, wait * slot), starts, strict=True):
        assert one.complete(joined) < joined + wait * slot + start
        first = one.first(joined)
        assert one.at(first) >= joined > one.at(first - 1)
        pieces = sorted(one.piece(n) for n in range(first, first + one.packets))
        assert [a for a, _ in pieces] + [one.size] == [0] + [b for _, b in pieces]  # all of it, nothing twice
        assert all(0 < b - a <= PAYLOAD for a, b in pieces)


@given(st.integers(1, 40), st.integers(1, 6))
def test_with_equal_segments_the_channels_are_those_of_the_polyharmonic_scheme(n, wait):
    made = channels([1000] * n, [i * SECOND for i in range(n)], wait * SECOND)
    scheme = polyharmonic(n, wait)
    assert [one.bandwidth / 1000 for one in made] == [one.bandwidth for one in scheme.channels]
    assert bytes_a_second(made) == 1000 * scheme.bandwidth


@given(sizes, slots, joins)
def test_the_guard_is_left_for_a_repair(sizes, slot, joined):
    guard = slot // 10
    starts = [n * slot for n in range(len(sizes))]
    for one, start in zip(channels(sizes, starts, slot, guard), starts, strict=True):
        assert one.complete(joined) < joined + slot + start - guard


def test_a_guard_as_long_as_the_wait_leaves_no_time():
    with pytest.raises(ValueError, match="guard"):
        channels([1], [0], SECOND, SECOND)


@pytest.mark.parametrize(("m", "goal"), [(1, False), (2, False), (3, False), (4, True), (8, True)])
def test_which_m_is_within_a_tenth_of_the_bound(m, goal):
    """120 s at 62.5 kB/s, everybody waits 4 s, with all headers and a guard of 0.1 s."""
    n = 30 * m
    made = channels(
        [120 * 62_500 // n] * n, [i * 4 * SECOND // m for i in range(n)], 4 * SECOND, SECOND // 10
    )  # fmt: skip
    ratio = float(bytes_a_second(made, DATAGRAM - PAYLOAD + UDP_IP)) / 62_500 / least(120, 4)
    assert HEAD.size + TAG == DATAGRAM - PAYLOAD
    assert (ratio <= 1.1) is goal


@given(st.integers(2, 30), st.integers(1, 4))
def test_packets_are_even(n, wait):
    (one,) = channels([n * PAYLOAD], [0], wait * SECOND)
    apart = {one.at(k + 1) - one.at(k) for k in range(3 * n)}
    assert max(apart) - min(apart) <= 1
    assert math.isclose(sum(apart) / len(apart), wait * SECOND / n, rel_tol=1e-6)
