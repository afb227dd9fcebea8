"""Edges of a broadcast that join at any time, with losses, with an origin that is gone or that shows another movie."""

import random
from dataclasses import replace

from hypothesis import given, settings
from hypothesis import strategies as st

from portal.broadcast.edge import GONE_NS, LATER_NS, SILENCE_NS
from portal.broadcast.timetable import SECOND
from tests.broadcasting import Air, movie, same

LONG = 2 + 6 + 0.5  # the wait, the movie, and a little


def test_ten_edges_play_one_broadcast():
    shown, joins = movie(), random.Random(7)
    air = Air(shown)
    for seed in range(10):
        air.go(joins.random())  # each at a moment of its own
        air.join(0.01, seed)
    air.go(LONG)
    assert all(same(edge, shown) for edge in air.edges)
    assert air.late == []
    assert sum(edge.packets_lost for edge in air.edges) > 10
    heard = sum(map(len, shown.contents)) * len(air.edges)
    assert 0 < air.asked < 0.03 * heard  # only lost packets, and little else, went to each edge alone


@settings(max_examples=25)
@given(st.integers(0, 20 * 500), st.integers(0, 3), st.integers(1, 14), st.integers(50, 20_000))
def test_without_losses_whoever_joins_at_any_moment_needs_the_broadcast_alone(at, seed, count, size):
    shown = movie(count, size, seed=seed)
    air = Air(shown)
    air.repairing = False
    air.go(at / 500)
    edge = air.join()
    air.go(2 + count / 2 + 0.1)
    assert same(edge, shown)
    assert air.late == []


def test_without_repairs_a_loss_is_made_good_in_the_next_cycle():
    shown = movie()
    air = Air(shown)
    air.repairing = False
    edge = air.join(0.05)
    air.go(4 * LONG)
    assert same(edge, shown)
    assert air.late != []  # so the test of being late can fail


def test_half_of_the_packets_lost_is_still_in_time_by_repairs():
    shown = movie()
    air = Air(shown)
    edge = air.join(0.5)
    air.go(LONG)
    assert same(edge, shown)
    assert air.late == []


def test_a_broadcast_that_ends_in_the_middle_goes_on_by_http():
    shown = movie()
    air = Air(shown)
    edge = air.join()
    air.go(3)
    assert not edge.current.whole
    air.go(LONG, sending=False)
    assert same(edge, shown)
    assert air.late == []


def test_an_origin_that_starts_again_with_the_same_movie_changes_nothing():
    shown = movie()
    air = Air(shown)
    edge = air.join(0.01)
    air.go(3)
    begun = edge.current
    air.broadcast(shown)
    air.go(LONG)
    assert edge.current is begun
    assert same(edge, shown)
    assert air.late == []
    assert edge.packets_lost < 50  # the numbers that the start skipped were never sent


def test_another_movie_replaces_it_and_the_one_before_stays_for_whoever_watches():
    first, second = movie(seed=1), movie(seed=2)
    air = Air(first)
    edge = air.join()
    air.go(LONG)
    before = edge.current
    air.broadcast(second)
    air.go(LONG)
    assert same(edge, second)
    assert air.late == []
    assert edge.before is before
    assert edge.find(before.movie) is before


def test_what_was_sent_for_the_movie_before_is_not_believed_again():
    first, second = movie(seed=1), movie(seed=2)
    air = Air(first)
    recorded = air.carousel.due(air.now_ns + SECOND // 2, 100)
    edge = air.join()
    air.broadcast(second)
    air.go(1)
    current, refused = edge.current, edge.refused
    for datagram in recorded:
        edge.hear(datagram, air.now_ns)
    assert edge.current is current
    assert edge.refused == refused + len(recorded) > refused


def test_an_origin_whose_clock_was_set_back_is_believed_after_a_silence():
    air = Air(movie(seed=1), number=10**9)
    edge = air.join()
    air.go(1)
    air.number = 10**6
    air.broadcast(movie(seed=2))
    air.go(2)
    assert edge.current.movie != air.carousel.movie
    air.go(SILENCE_NS / SECOND, sending=False)
    air.go(LONG)
    assert same(edge, air.movie)


def test_a_short_pause_of_the_origin_is_made_good():
    shown = movie()
    air = Air(shown)
    edge = air.join()
    air.go(1)
    air.now_ns += SECOND * 3 // 2
    air.go(LONG)
    assert same(edge, shown)
    assert edge.packets_lost == 0
    assert air.carousel.skipped == 0


def test_a_longer_pause_is_left_out_and_repaired_and_the_timetable_holds():
    shown = movie()
    air = Air(shown)
    edge = air.join()
    air.go(3)
    assert (air.late, air.asked, air.carousel.skipped) == ([], 0, 0)
    air.now_ns += 3 * SECOND
    joined = air.join()
    air.go(LONG)
    assert air.carousel.skipped == 1
    assert air.asked > 0
    assert same(edge, shown)
    assert same(joined, shown)
    assert [late for late in air.late if late[0] is joined] == []


def test_an_origin_whose_machine_slept_sends_no_flood():
    air = Air(movie())
    air.now_ns += 3600 * SECOND
    assert len(air.carousel.due(air.now_ns, 1000)) < 20  # and not an hour of packets at once
    edge = air.join()
    air.go(LONG)
    assert same(edge, air.movie)
    assert air.late == []


def test_movies_have_so_many_bytes_together_and_no_more():
    first, second = movie(seed=1), movie(seed=2)
    size = sum(map(len, first.contents))
    air = Air(first)
    edge, small = air.join(), air.join()
    small._most = edge._most = size * 3 // 2
    air.go(LONG)
    assert same(edge, first)
    air.broadcast(second)
    air.go(LONG)
    assert edge.before is None  # there was no room for both
    assert same(edge, second)
    air.broadcast(replace(movie(count=40, seed=3)))
    air.go(4 * LONG)
    assert not edge.current.whole
    assert edge.current.size <= edge._most


def test_a_movie_that_is_no_longer_sent_is_forgotten_for_it_may_be_withdrawn():
    air = Air(movie())
    edge = air.join()
    air.go(LONG)
    number = edge.current.movie
    air.go(GONE_NS / SECOND - 1, sending=False)
    assert edge.find(number) is not None, "the origin may be about to begin again"
    air.go(2, sending=False)
    assert edge.current is None and edge.find(number) is None
    shown = movie(seed=2)
    air.broadcast(shown)
    air.go(LONG)
    assert same(edge, shown) and edge.before is None
    assert air.late == []


def test_the_one_before_goes_too_when_nothing_is_sent():
    air = Air(movie(seed=1))
    edge = air.join()
    air.go(LONG)
    air.broadcast(movie(seed=2))
    air.go(3)
    assert edge.before is not None
    air.go(GONE_NS / SECOND + 1, sending=False)
    assert edge.current is None and edge.before is None


def test_the_one_before_is_forgotten_when_whoever_watched_it_has_seen_its_end():
    air = Air(movie(seed=1))
    edge = air.join()
    air.go(LONG)
    air.broadcast(movie(seed=2))
    air.go(2 + 6 + LATER_NS / SECOND - 1)
    assert edge.before is not None
    air.go(2)
    assert edge.before is None and edge.current.whole
