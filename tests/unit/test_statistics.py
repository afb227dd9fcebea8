"""Counting of jobs and motions: two days beside each other add up to both, and nothing falls out of the plots."""

from datetime import UTC, datetime, timedelta
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from portal.web.statistics import plots
from portal.web.statistics.counting import (
    ATTEMPTED,
    CANCELLED,
    FAULT,
    GAVE_UP,
    MOST_BINS,
    OPEN,
    REACHED,
    REFUSED,
    UNKNOWN,
    Ask,
    Motion,
    attempted,
    by_hour,
    course,
    growth,
    outcomes,
    readings,
    round_step,
    seconds_of,
    success,
)
from portal.web.statistics.day import BadDate, span_of
from portal.web.statistics.reading import outcome_of

NOW = datetime(2026, 3, 31, 18, 30, tzinfo=UTC)
START = NOW - timedelta(hours=24)
WORDS = (REACHED, GAVE_UP, FAULT, UNKNOWN, REFUSED, CANCELLED, OPEN, "map_cleared")
counters = st.lists(st.floats(0, 1e6), max_size=30)
asks = st.lists(
    st.builds(
        Ask, st.integers(-600, 2000).map(lambda m: START + timedelta(minutes=m)), st.sampled_from(WORDS),
        st.sampled_from("abc"), st.none() | st.floats(allow_nan=False),
    )
)  # fmt: skip
motions = st.lists(
    st.tuples(st.sampled_from(["goal", "charge"]), st.integers(0, 3000), st.integers(0, 600)).map(
        lambda m: Motion(m[0], "completed", START + timedelta(minutes=m[1] - m[2]), START + timedelta(minutes=m[1]))
    )
)


@given(counters, st.integers(0, 30))
def test_a_counter_grows_as_much_in_two_parts_as_in_both(values, cut):
    one, other = values[:cut], values[cut:]
    parts = (growth(one) or 0.0) + (growth(other, one[-1] if one else None) or 0.0)
    assert parts == pytest.approx(growth(values) or 0.0)


def test_a_counter_that_begins_anew_counts_what_it_shows():
    assert growth([5.0, 7.0, 2.0, 3.0]) == 2.0 + 2.0 + 1.0
    assert growth([1.0], before=4.0) == 1.0
    assert growth([]) is growth([], before=4.0) is None


@given(motions, st.integers(0, 2880))
def test_time_in_motion_adds_up_over_neighbouring_spans(found, cut):
    end, middle = START + timedelta(minutes=2880), START + timedelta(minutes=cut)
    parts = seconds_of(found, ("goal",), START, middle) + seconds_of(found, ("goal",), middle, end)
    assert parts == pytest.approx(seconds_of(found, ("goal",), START, end))


@given(asks)
def test_every_job_is_counted_once_and_success_never_exceeds_what_was_attempted(found):
    counts = outcomes(found)
    assert counts.total() == len(found)
    assert counts[REACHED] <= attempted(counts) <= len(found)
    hours = by_hour(found, START)
    assert sum(asked for asked, _ in hours) == sum(START <= a.at < NOW for a in found)
    assert all(done <= asked for asked, done in hours)


@given(asks, st.sampled_from([(0.0, 10_000.0), (0.0, 1.0), (-1e6, 1e6), (3.0, 3.0)]))
def test_success_is_told_in_few_bins_that_hold_every_attempt_of_known_value(found, bounds):
    bins = success(found, *bounds)
    known = [a for a in found if a.value is not None and a.outcome in ATTEMPTED]
    assert sum(one.attempted for one in bins) == len(known)
    assert sum(one.done for one in bins) == sum(a.outcome == REACHED for a in known)
    assert len(bins) <= MOST_BINS
    assert all(a.high == b.low for a, b in pairwise(bins))


@given(st.floats(0, 1e9), st.floats(0, 1e9))
def test_a_step_is_round_and_the_least_that_is_enough(a, b):
    least, most = sorted((a, b))
    step = round_step(least, most)
    assert most // step - least // step < MOST_BINS
    assert str(int(step)).rstrip("0") in ("1", "2", "5")


def test_how_a_job_ended_is_read_from_its_row_and_its_last_command():
    own = frozenset({"map_cleared"})
    told = {
        ("done", 0, "completed", ""): REACHED, ("cancelled", 0, "cancelled", ""): CANCELLED,
        ("waiting", 1, "failed", ""): OPEN, ("running", 0, "acknowledged", ""): OPEN, ("unknown", 0, "unknown", ""): UNKNOWN,
        ("failed", 0, "rejected", "map_cleared"): "map_cleared", ("failed", 0, "rejected", "bad_request"): REFUSED,
        ("failed", 0, "failed", "gave_up"): GAVE_UP, ("failed", 3, "failed", ""): FAULT,
        ("failed", 1, "cancelled", ""): GAVE_UP,  # its time was up
    }  # fmt: skip
    assert {known: outcome_of(*known, own) for known in told} == told


def test_the_course_of_a_channel_is_one_mean_in_five_minutes():
    found = [
        Motion("goal", "completed", START, START + timedelta(minutes=2), {"battery": 8.0}, {"battery": 7.0}),
        Motion("goal", "completed", NOW - timedelta(minutes=1), NOW, {"battery": 6.5}, {"battery": 9.9}),
        Motion("goal", "completed", START, START, {}, {"other": 1.0}),
    ]
    assert course(found, "battery", START, NOW) == [(pytest.approx(1 / 24), 7.5), (pytest.approx(24 - 1 / 24), 6.5)]
    assert readings(found, "battery") == [8.0, 7.0, 6.5, 9.9]


@pytest.mark.parametrize(
    ("text", "start"),
    [
        ("", NOW - timedelta(hours=24)),
        ("2026-03-30", datetime(2026, 3, 30, tzinfo=UTC)),
        ("2026-03-30T18:30", datetime(2026, 3, 30, 18, 30, tzinfo=UTC)),
        ("2026-03-30T18:30:00Z", datetime(2026, 3, 30, 18, 30, tzinfo=UTC)),
        ("2026-03-30T18:30:00+02:00", datetime(2026, 3, 30, 16, 30, tzinfo=UTC)),
    ],
)
def test_any_24_hours_can_be_asked_for(text, start):
    span = span_of(text, NOW)
    assert (span.start, span.end) == (start, start + timedelta(hours=24))
    assert span.until == min(span.end, NOW)


@pytest.mark.parametrize(
    "text",
    ["yesterday", "2026-02-30", "2026-03-30T25:00", "1999-01-01", "2026-04-01", "9999-12-31T23:59-23:00",
     "0001-01-01T00:00+23:59", "²026-01-01", "1e308", "nan", "-1", "2026-03-30T18:30" * 9],
)  # fmt: skip
def test_a_bad_date_is_refused_in_words(text):
    with pytest.raises(BadDate, match=r"\."):
        span_of(text, NOW)


@given(asks, st.lists(st.tuples(st.floats(0, 24), st.floats()), max_size=20))
def test_nothing_is_drawn_outside_a_plot(found, points):
    drawn = [
        plots.hours(by_hour(found, START), START, "goal", "goals", "reached"),
        plots.success(success(found, 0.0, 1e4), "reached"),
        plots.line(points, 6.4, 8.4, START),
    ]
    for plot in drawn:
        for bar in plot.bars:
            assert plots.LEFT <= bar.x <= bar.x + bar.width <= plots.RIGHT
            assert plots.TOP - 1e-9 <= bar.y <= bar.y + bar.height <= plots.BOTTOM + 1e-9
        for corner in plot.line.split():
            x, y = map(float, corner.split(","))
            assert plots.LEFT <= x <= plots.RIGHT and plots.TOP <= y <= plots.BOTTOM
        assert len(plot.up) <= 14
