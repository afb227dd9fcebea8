"""How drivers wait, on a clock that is moved by hand."""

import pytest

from robots.kit.clock import Limit, poll
from robots.kit.contract.errors import HardwareFault, MotionHeld
from robots.kit.contract.session import RobotState
from robots.kit.drivers.permits import unless_held, until_at_rest

REST, MOTION = (RobotState(0.0, (), (), moving, True) for moving in (False, True))


def test_a_limit_is_over_after_its_seconds_and_not_at_them(clock):
    limit = Limit(clock, 2.0)
    assert (limit.remaining, limit.over) == (2.0, False)
    clock.go(2.0)
    assert (limit.remaining, limit.over) == (0.0, False)
    clock.go(0.5)
    assert (limit.remaining, limit.over) == (-0.5, True)


def test_something_is_looked_for_until_it_is_so_or_the_limit_is_over(clock):
    assert poll(lambda: clock.t >= 1001.0, clock, 2.0, 0.25)
    assert clock.t == 1001.0
    assert not poll(lambda: False, clock, 2.0, 0.25)
    assert clock.t == 1003.25, "it looks once more after the limit"


def test_rest_is_waited_for(clock):
    states = iter([MOTION, MOTION, REST])
    assert until_at_rest(lambda: next(states), clock, 1.0, "The arm", 0.1) is REST
    assert clock.t == pytest.approx(1000.2)


def test_what_does_not_come_to_rest_is_a_fault_by_name_at_the_limit(clock):
    with pytest.raises(HardwareFault, match="The arm did not come to rest after a hold"):
        until_at_rest(lambda: MOTION, clock, 1.0, "The arm", 0.25)
    assert clock.t == pytest.approx(1001.25)


def test_rest_that_is_heard_late_is_rest(clock):
    def ask():
        clock.go(60.0)
        return REST

    assert until_at_rest(ask, clock, 1.0, "The arm") is REST


def test_an_error_of_the_question_is_passed_on(clock):
    def ask():
        raise HardwareFault("The line is gone.")

    with pytest.raises(HardwareFault, match="line is gone"):
        until_at_rest(ask, clock, 1.0, "The arm")


def test_a_hold_from_now_on_ends_it_and_one_of_before_does_not():
    holds = [3]
    free = unless_held(lambda: holds[0], "A stop came first.")
    free()
    holds[0] += 1
    with pytest.raises(MotionHeld, match="A stop came first"):
        free()
    unless_held(lambda: holds[0])()
