"""Pictures become slower when the process's own loops are late, and recover automatically."""

import math

from hypothesis import given
from hypothesis import strategies as st

from robots.kit.brownout import ONLY_STILLS, STEPS, Brownout

USUAL_S = 0.1


def live(brownout, late, seconds, since=0.0):
    now = since
    while now < since + seconds:
        now += 0.05 + late
        brownout.feel(late, now)
    return now


def test_a_machine_at_ease_slows_nothing():
    brownout = Brownout()
    live(brownout, 0.002, 20)
    assert brownout.every_s(USUAL_S) == USUAL_S


def test_five_then_two_then_only_stills_and_back_within_fifteen_seconds():
    brownout, now, seen = Brownout(), 0.0, []
    for late in (0.05, 0.15, 0.4):
        now = live(brownout, late, 5, now)
        seen.append(brownout.every_s(USUAL_S))
    assert seen == [0.2, 0.5, math.inf]
    now = live(brownout, 0.002, 12, now)
    assert brownout.every_s(USUAL_S) == USUAL_S


def test_one_stall_alone_does_not_stop_pictures():
    brownout = Brownout()
    now = live(brownout, 0.001, 10)
    brownout.feel(0.3, now + 0.35)
    assert brownout.level == 0


def test_a_robot_that_is_slow_anyway_is_not_made_faster():
    brownout = Brownout()
    live(brownout, 0.05, 5)
    assert brownout.every_s(1.0) == 1.0


@given(st.lists(st.floats(-1, 100), min_size=1, max_size=200))
def test_whatever_is_felt_it_recovers(lates):
    brownout, now = Brownout(), 0.0
    for late in lates:
        now += 0.05 + max(late, 0)
        brownout.feel(late, now)
        assert 0 <= brownout.level <= ONLY_STILLS == len(STEPS) - 1
    live(brownout, 0.0, 3.5 * ONLY_STILLS + 3, now)
    assert brownout.level == 0
