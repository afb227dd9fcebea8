"""The dead-man timer of a held motion: what ends it, and that nothing brings it back."""

from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.drivers.errors import ControlsReleased
from robots.services import START_S
from tests.conftest import FakeClock
from workers.safety.deadman import SILENT_S, DeadManTimer

ADA, SEQ = 7, 3


def taken(limit_s=20.0):
    clock = FakeClock()
    timer = DeadManTimer(clock)
    timer.start(SimpleNamespace(issued_by_id=ADA, client_seq=SEQ, limit_s=limit_s))
    return clock, timer


@given(st.lists(st.floats(0.0, 0.6), min_size=1, max_size=12))
def test_a_keep_alive_that_comes_too_late_brings_nothing_back(pauses):
    clock, timer = taken()
    lost = False
    for pause in pauses:
        clock.sleep(pause)
        lost = lost or pause > SILENT_S + 1e-9
        if abs(pause - SILENT_S) < 1e-6:
            return  # at the very edge either is right
        timer.hear(ADA, SEQ, True)
        assert timer.ended == ("lost" if lost else "")
    if lost:
        with pytest.raises(ControlsReleased):
            timer.check()


def test_somebody_elses_controls_neither_keep_nor_release_it():
    clock, timer = taken()
    timer.hear(ADA + 1, SEQ, False)
    timer.hear(ADA, SEQ - 1, False)
    assert not timer.ended
    clock.sleep(SILENT_S + 0.01)
    timer.hear(ADA + 1, SEQ, True)
    assert timer.ended == "lost"


def test_it_ends_when_released_and_when_it_has_lasted_long_enough():
    _, timer = taken()
    timer.hear(ADA, SEQ, False)
    assert timer.ended == "released"
    clock, timer = taken(limit_s=1.0)
    for _ in range(9):
        clock.sleep(0.1)
        timer.hear(ADA, SEQ, True)
        assert not timer.ended
    clock.sleep(0.11)
    assert timer.ended == "long"


def test_what_was_released_in_an_earlier_turn_does_not_end_a_motion_of_the_same_number():
    """Numbers start again with each turn; a quick tap may be released before its motion begins."""
    clock, timer = taken()
    timer.hear(ADA, SEQ, False)
    timer.end()
    clock.sleep(START_S + 1.0)
    timer.start(SimpleNamespace(issued_by_id=ADA, client_seq=SEQ, limit_s=20.0))
    assert not timer.ended
    timer.end()
    timer.hear(ADA, SEQ + 1, False)
    clock.sleep(1.0)
    timer.start(SimpleNamespace(issued_by_id=ADA, client_seq=SEQ + 1, limit_s=20.0))
    assert timer.ended == "released"
