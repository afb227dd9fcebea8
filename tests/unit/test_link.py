"""When the live link counts as down: by the time at which Redis was asked, however late the answer is heard."""

from types import SimpleNamespace

import pytest

from robots import bus
from tests.conftest import FakeClock
from workers.authority.lane import Pace
from workers.authority.memory import Link
from workers.guard.follow import Follower

GONE_S = 1.5


@pytest.mark.parametrize("late_s", [0.0, 0.4, 1.2])
def test_an_answer_speaks_for_the_time_of_its_question(monkeypatch, late_s):
    clock = FakeClock()
    link, owned = Link(clock, GONE_S), SimpleNamespace(running=True, clock=clock)
    asked = clock.monotonic()

    def alive():
        clock.sleep(late_s)  # the answer is there, but this thread does not run
        owned.running = False
        return True

    monkeypatch.setattr(bus, "alive", alive)
    Follower(owned, SimpleNamespace(link=link, grants=None), (), None, Pace(clock)).ask_link()
    clock.sleep(asked + GONE_S - 0.01 - clock.monotonic())
    assert not link.down
    clock.sleep(0.02)
    assert link.down
    assert link.lost_at == asked + GONE_S
