"""Harmonic broadcasting as the papers describe it: bandwidth, and who has which part of the movie in time."""

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from portal.broadcast.schedule import Channel, Scheme, cautious, harmonic, lateness, least, on_time, polyharmonic

segments = st.integers(3, 12)
waits = st.integers(1, 6)
joins = st.builds(Fraction, st.integers(0, 400), st.integers(1, 12))


def H(n: int) -> Fraction:
    return sum((Fraction(1, i) for i in range(1, n + 1)), Fraction(0))


@given(segments, waits)
def test_the_bandwidths_are_the_published_ones(n, m):
    assert harmonic(n).bandwidth == H(n)
    assert cautious(n).bandwidth == H(n - 1) + Fraction(1, 2)
    assert polyharmonic(n, m).bandwidth == H(n + m - 1) - H(m - 1)
    assert all(scheme.segments == n for scheme in (harmonic(n), cautious(n), polyharmonic(n, m)))


def test_thirty_segments_and_the_bound():
    assert float(harmonic(30).bandwidth) == pytest.approx(3.995, abs=5e-4)
    assert least(120, 4) == pytest.approx(3.434, abs=5e-4)
    four = polyharmonic(120, 4)  # a wait of 4 s for a movie of 120 s, in slots of 1 s
    assert float(four.bandwidth) / least(120, 4) == pytest.approx(1.037, abs=5e-4)


@given(segments, joins)
def test_cautious_is_on_time_for_every_joiner(n, joined):
    assert on_time(cautious(n), joined)


@given(segments, waits, joins)
def test_polyharmonic_is_on_time_for_every_joiner_a_whole_segment_ahead(n, m, joined):
    scheme = polyharmonic(n, m)
    assert on_time(scheme, joined)
    for segment in range(1, n + 1):  # all of it is there when its first place is shown: what players need
        last = Fraction(segment) - Fraction(1, 10**9)
        assert scheme.received(last, joined) <= scheme.begin(joined) + segment - 1


def test_harmonic_is_late_for_a_joiner_who_hears_the_second_half_of_the_second_segment_first():
    scheme = harmonic(2)
    assert on_time(scheme, 0)  # the first half comes in the first slot
    assert lateness(scheme, 1) == Fraction(1, 2)
    place = Fraction(149, 100)  # of the first half, which comes while it is shown, half as fast
    assert scheme.received(place, 1) == Fraction(298, 100) > scheme.begin(1) + place == Fraction(249, 100)


@given(segments)
def test_harmonic_would_need_almost_a_slot_more(n):
    """(n - 1) / n slots, as Paris, Carter and Long found."""
    scheme = harmonic(n)
    latest = max(lateness(scheme, joined) for joined in range(n * (n - 1)))
    assert latest == Fraction(n - 1, n)


@given(st.sampled_from((harmonic, cautious, polyharmonic)), segments, joins, st.lists(st.fractions(0, 1), max_size=20))
def test_no_place_is_later_than_the_latest(make, n, joined, shares):
    scheme = make(n)
    latest = lateness(scheme, joined)
    places = [n * share for share in shares if share < 1] + [
        end - Fraction(1, 10**6) for end in [*map(Fraction, range(1, n + 1))]
    ]
    found = max(scheme.received(place, joined) - scheme.begin(joined) - place for place in places)
    assert found <= latest


@given(st.sampled_from((harmonic, cautious, polyharmonic)), segments, joins)
def test_the_latest_place_is_near_an_end(make, n, joined):
    """The bound is the least one: some place is as late as one likes."""
    scheme, little = make(n), Fraction(1, 10**9)
    ends = [Fraction(i) for i in range(1, n + 1)] + [
        now for channel in scheme.channels if (now := channel.place(joined)) % 1
    ]
    found = max(scheme.received(end - little, joined) - scheme.begin(joined) - (end - little) for end in ends)
    assert 0 <= lateness(scheme, joined) - found < Fraction(1, 10**6)


@given(st.integers(1, 9), joins)
def test_a_channel_sends_what_it_says_it_sends(slots, at):
    channel = Channel((2, 3), slots)
    place = channel.place(at)
    assert 1 <= place < 3
    assert channel.next_time(place, at) == at


@given(segments, waits, joins)
def test_one_slot_more_on_any_channel_is_late_for_somebody(n, m, joined):
    """The check finds what it is for: each channel of the scheme is as slow as it may be."""
    channels = list(polyharmonic(n, m).channels)
    slow = int(joined) % n
    channels[slow] = Channel(channels[slow].segments, channels[slow].slots + 1)
    worse = Scheme("polyharmonic", tuple(channels), m)
    assert not all(on_time(worse, Fraction(at, 3)) for at in range(3 * channels[slow].slots))


def test_two_segments_are_too_few_for_the_cautious_scheme():
    with pytest.raises(ValueError, match="three"):
        cautious(2)
