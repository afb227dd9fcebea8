"""Cheers: counted in their own turn alone, and no more of them than the limits allow."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from portal.edge.limits import AddressRate
from portal.live import cheers
from portal.live.cheers import Cheers
from portal.live.people import Role

GRANTS = st.integers(0, 3)
STEPS = st.lists(
    st.one_of(
        st.tuples(st.just("cheer"), st.just(0)),
        st.tuples(st.just("follow"), GRANTS),
        st.tuples(st.just("ask"), st.just(0)),
        st.tuples(st.just("answer"), st.just(0)),
    ),
    max_size=40,
)


class Clock:
    now = 1000.0

    def __call__(self):
        return self.now


@pytest.fixture
def clock(monkeypatch):
    clock = Clock()
    monkeypatch.setattr(cheers, "OF_PERSON", AddressRate(0.2, 3.0, clock))
    monkeypatch.setattr(cheers, "OF_NETWORK", AddressRate(0.5, 10.0, clock))
    return clock


@given(STEPS)
def test_each_cheer_reaches_the_counter_of_its_own_turn_once_whatever_comes_meanwhile(steps):
    """`ask` carries the new cheers to a counter, whose `answer` comes later; a turn that ends takes its last cheers."""
    mine, redis, made, dropped, asked = Cheers(), {}, {}, {}, None
    for what, grant in steps:
        if what == "cheer" and mine.grant:
            mine.new += 1
            made[mine.grant] = made.get(mine.grant, 0) + 1
        elif what == "follow" and asked is None:
            if grant != mine.grant:
                dropped[mine.grant] = dropped.get(mine.grant, 0) + mine.new
            mine.follow(grant)
        elif what == "ask" and asked is None and mine.grant:
            asked = (mine.grant, mine.new)
            redis[mine.grant] = redis.get(mine.grant, 0) + mine.new
        elif what == "answer" and asked is not None:
            changed = mine.note_count(*asked, redis[asked[0]])
            assert not changed or mine.count == redis[mine.grant]
            asked = None
        assert mine.new >= 0
    if asked is not None:
        mine.note_count(*asked, redis[asked[0]])
    for grant, many in made.items():
        assert redis.get(grant, 0) + dropped.get(grant, 0) + (mine.new if mine.grant == grant else 0) == many


def test_an_answer_about_a_turn_that_is_over_changes_nothing():
    mine = Cheers()
    mine.follow(7)
    mine.new = 4
    mine.follow(8)
    mine.new = 1
    assert not mine.note_count(7, 4, 4)
    assert (mine.new, mine.count, mine.text()) == (1, 0, "")


def test_a_network_of_strangers_cheers_ten_times_and_then_once_in_two_seconds(clock):
    mine = Cheers()
    mine.follow(7)
    stranger = Role(anonymous=True)
    answers = [mine.cheer(stranger, f"2001:db8::{n:x}") for n in range(500)]  # one IPv6 network
    assert sum(one.ok for one in answers) == mine.new == 10
    assert {one.code for one in answers if not one.ok} == {"too_often"}
    assert mine.cheer(stranger, "198.51.100.7").ok, "another network"
    clock.now += 2.0
    assert [mine.cheer(stranger, "2001:db8::1").ok for _ in range(2)] == [True, False]


def test_a_person_cheers_three_times_and_then_once_in_five_seconds_wherever_they_are(clock):
    mine = Cheers()
    mine.follow(7)
    assert [mine.cheer(Role(3), f"198.51.100.{n}").ok for n in range(5)] == [True] * 3 + [False] * 2
    assert mine.cheer(Role(4), "198.51.100.1").ok, "somebody else"
    assert mine.cheer(Role(anonymous=True), "3").ok, "an address is no account"
    clock.now += 5.0
    assert mine.cheer(Role(3), "198.51.100.9").ok


def test_nobody_is_cheered_where_nobody_drives_and_nobody_cheers_for_themselves(clock):
    mine = Cheers()
    assert mine.cheer(Role(3), "198.51.100.1").code == "not_driven"
    mine.follow(7)
    assert mine.cheer(Role(3, grant=7), "198.51.100.1").code == "drives"
    assert mine.new == 0
