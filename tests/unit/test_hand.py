"""The hand on a held motion: what ends it, and that nothing brings it back."""

from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.drivers.errors import HandGone
from robots.services import START_S
from tests.conftest import FakeClock
from workers.hand import SILENT_S, Hand

ADA, SEQ = 7, 3


def taken(limit_s=20.0):
    clock = FakeClock()
    hand = Hand(clock)
    hand.take(SimpleNamespace(issued_by_id=ADA, client_seq=SEQ, limit_s=limit_s))
    return clock, hand


@given(st.lists(st.floats(0.0, 0.6), min_size=1, max_size=12))
def test_a_keep_alive_that_comes_too_late_does_not_bring_the_hand_back(pauses):
    clock, hand = taken()
    lost = False
    for pause in pauses:
        clock.sleep(pause)
        lost = lost or pause > SILENT_S + 1e-9
        if abs(pause - SILENT_S) < 1e-6:
            return  # at the very edge either is right
        hand.feel(ADA, SEQ, True)
        assert hand.gone == ("lost" if lost else "")
    if lost:
        with pytest.raises(HandGone):
            hand.check()


def test_another_hand_neither_keeps_it_nor_lets_it_go():
    clock, hand = taken()
    hand.feel(ADA + 1, SEQ, False)
    hand.feel(ADA, SEQ - 1, False)
    assert not hand.gone
    clock.sleep(SILENT_S + 0.01)
    hand.feel(ADA + 1, SEQ, True)
    assert hand.gone == "lost"


def test_it_ends_when_let_go_and_when_it_has_lasted_long_enough():
    _, hand = taken()
    hand.feel(ADA, SEQ, False)
    assert hand.gone == "released"
    clock, hand = taken(limit_s=1.0)
    for _ in range(9):
        clock.sleep(0.1)
        hand.feel(ADA, SEQ, True)
        assert not hand.gone
    clock.sleep(0.11)
    assert hand.gone == "long"


def test_what_was_let_go_in_an_earlier_turn_does_not_end_a_motion_of_the_same_number():
    """Numbers begin anew with each turn; a quick tap may be let go before its motion begins."""
    clock, hand = taken()
    hand.feel(ADA, SEQ, False)
    hand.end()
    clock.sleep(START_S + 1.0)
    hand.take(SimpleNamespace(issued_by_id=ADA, client_seq=SEQ, limit_s=20.0))
    assert not hand.gone
    hand.end()
    hand.feel(ADA, SEQ + 1, False)
    clock.sleep(1.0)
    hand.take(SimpleNamespace(issued_by_id=ADA, client_seq=SEQ + 1, limit_s=20.0))
    assert hand.gone == "released"
