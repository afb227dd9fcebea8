"""The dead-man timer of a held motion: what lets it begin, what ends it, and that nothing brings it back."""

from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.kit.contract.errors import ControlsReleased
from robots.services import START_S
from tests.conftest import FakeClock
from workers.guard.deadman import SILENT_S, DeadManTimer

SEQ = 3  # the key of a command


def command(seq=SEQ, limit_s=20.0):
    return SimpleNamespace(pk=seq, limit_s=limit_s)


def taken(limit_s=20.0):
    """Return the clock and the timer of a motion that has just begun: its press was heard."""
    clock = FakeClock()
    timer = DeadManTimer(clock)
    timer.hear(SEQ, True)
    timer.start(command(limit_s=limit_s))
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
        timer.hear(SEQ, True)
        assert timer.end_reason == ("lost" if lost else "")
    if lost:
        with pytest.raises(ControlsReleased):
            timer.check()


@given(st.lists(st.floats(0.0, 2.0), max_size=12), st.floats(0.0, 4.4))
def test_a_motion_that_waited_begins_only_if_its_controls_were_heard_a_moment_ago(pauses, silence):
    """Behind another motion only the last quarter of a second counts, whatever was heard before."""
    clock, timer = FakeClock(), None
    timer = DeadManTimer(clock)
    timer.hear(SEQ - 1, True)
    timer.start(command(SEQ - 1))
    for pause in pauses:
        timer.hear(SEQ, True)
        clock.sleep(pause)
    timer.hear(SEQ, True)
    clock.sleep(silence)
    timer.end()
    if abs(silence - SILENT_S) < 1e-6:
        return
    timer.start(command())
    assert timer.end_reason == ("" if silence < SILENT_S else "lost")
    timer.hear(SEQ, True)
    assert timer.end_reason == ("" if silence < SILENT_S else "lost"), (
        "a keep-alive that comes later brings nothing back"
    )


def test_the_press_may_come_a_little_later_than_its_command():
    clock = FakeClock()
    timer = DeadManTimer(clock)
    slept, sleep = [], clock.sleep

    def heard_meanwhile(seconds):
        slept.append(seconds)
        sleep(seconds)
        if len(slept) == 3:
            timer.hear(SEQ, True)

    clock.sleep = heard_meanwhile
    timer.start(command())
    assert (timer.end_reason, len(slept)) == ("", 3)
    timer.end()
    clock.sleep = sleep
    begun = clock.monotonic()
    timer.start(command(SEQ + 1))
    assert timer.end_reason == "lost", "nobody holds it"
    assert clock.monotonic() - begun < SILENT_S + 0.05


@pytest.mark.parametrize("keeps", [0, 1, 30])
def test_a_press_and_its_release_that_a_stalled_line_delivers_together_move_nothing(keeps):
    """Several quick taps, too: each release counts, not only the last one."""
    clock = FakeClock()
    timer = DeadManTimer(clock)
    for seq in (SEQ, SEQ + 1, SEQ + 2):
        for _ in range(keeps):
            timer.hear(seq, True)
        timer.hear(seq, False)
    for seq in (SEQ, SEQ + 1, SEQ + 2):
        timer.start(command(seq))
        assert timer.end_reason == "released", seq
        timer.hear(seq, True)
        assert timer.end_reason == "released", seq
        timer.end()
        clock.sleep(1.0)


def test_controls_of_other_commands_neither_keep_nor_release_it():
    clock, timer = taken()
    timer.hear(SEQ + 5, False)
    timer.hear(SEQ - 1, False)
    assert not timer.end_reason
    clock.sleep(SILENT_S + 0.01)
    timer.hear(SEQ + 5, True)
    assert timer.end_reason == "lost"
    timer.end()
    timer.hear(SEQ + 6, True)
    timer.start(command(SEQ + 1))
    assert timer.end_reason == "lost"


def test_it_ends_when_released_and_when_it_has_lasted_long_enough():
    clock, timer = taken()
    timer.hear(SEQ, False)
    assert timer.end_reason == "released"
    clock.sleep(START_S + 1.0)
    timer.hear(SEQ, True)
    assert timer.end_reason == "released", "for as long as it runs"
    clock, timer = taken(limit_s=1.0)
    for _ in range(9):
        clock.sleep(0.1)
        timer.hear(SEQ, True)
        assert not timer.end_reason
    clock.sleep(0.11)
    assert timer.end_reason == "long"


def test_a_tap_that_was_released_before_its_motion_begins_ends_it_a_second_later():
    clock, timer = taken()
    timer.hear(SEQ + 1, False)
    timer.end()
    clock.sleep(1.0)
    timer.start(command(SEQ + 1))
    assert timer.end_reason == "released"


def test_words_of_controls_are_forgotten():
    clock = FakeClock()
    timer = DeadManTimer(clock)
    for seq in range(1000):
        timer.hear(seq, seq % 2 == 0)
        clock.sleep(1.0)
    assert len(timer._waiting) + len(timer._let_go) < 2 * START_S


def steered(judge=lambda args: all(abs(value) <= 1 for value in args.values())):
    clock = FakeClock()
    timer = DeadManTimer(clock)
    timer.hear(SEQ, True)
    timer.start(command(), judge)
    return clock, timer


NUMBERS = st.floats(allow_nan=True, allow_infinity=True) | st.floats(-1, 1)


@given(st.lists(st.tuples(st.sampled_from("xy"), NUMBERS, st.floats(0.0, 0.3), st.sampled_from((SEQ, SEQ + 1)))))
def test_the_latest_value_wins_and_one_that_is_refused_counts_for_nothing(told):
    clock, timer = steered()
    newest, heard, lost = {}, 0.0, False
    begun = clock.monotonic()
    for name, value, pause, which in told:
        clock.sleep(pause)
        now = clock.monotonic() - begun
        if abs(now - heard - SILENT_S) < 1e-6:
            return  # at the very edge either is right
        timer.hear(which, True, {name: value})
        lost = lost or now - heard > SILENT_S
        if which == SEQ and abs(value) <= 1 and not lost:
            newest[name], heard = value, now
        assert timer.steered == newest
        assert timer.end_reason == ("lost" if lost else "")


def test_values_of_a_motion_that_is_not_steered_count_for_nothing():
    clock, timer = taken()
    clock.sleep(SILENT_S - 0.01)
    timer.hear(SEQ, True, {"x": 0.5})
    assert timer.steered == {}
    clock.sleep(0.02)
    assert timer.end_reason == "lost"


def test_the_next_motion_begins_at_its_own_values():
    _, timer = steered()
    timer.hear(SEQ, True, {"x": 0.5})
    timer.end()
    assert timer.steered == {}
    timer.hear(SEQ + 1, True)
    timer.start(command(SEQ + 1), lambda args: True)
    assert timer.steered == {}
