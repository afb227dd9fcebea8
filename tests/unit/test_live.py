"""The loop of a camera keeps its pace by one reading of the clock a round."""

from types import SimpleNamespace

import pytest

from robots.kit.brownout import ONLY_STILLS, Brownout
from tests.conftest import FakeClock
from workers.guard.watch import Watch
from workers.robot.live import send_live


class Restless(FakeClock):
    """A busy machine's clock: every look at it takes time; sleeping less than nothing raises, as time.sleep does."""

    step = 0.0
    at_end = (float("inf"), None)

    def monotonic(self):
        self.t += self.step
        return self.t

    def sleep(self, seconds):
        if seconds < 0:
            raise ValueError("sleep length must be non-negative")
        super().sleep(seconds)
        end, stop = self.at_end
        if self.t >= end:
            stop()


def taken(clock, seconds, grab_s=0.0, every_s=0.1, level=0):
    """Return when pictures were taken."""
    at, end = [], clock.t + seconds

    def live_once(state, camera):
        at.append(clock.t)
        clock.t += grab_s
        owned.running = clock.t < end
        return True

    owned = SimpleNamespace(clock=clock, running=True, driver=SimpleNamespace(latest=lambda: None))
    brownout = Brownout()
    brownout.level = level
    if level == ONLY_STILLS:  # nothing is taken that would end it
        clock.at_end = (end, lambda: setattr(owned, "running", False))
    send_live(owned, SimpleNamespace(every_s=every_s, live_once=live_once), brownout)
    return at


def test_a_clock_that_goes_on_between_two_looks_ends_no_camera():
    for step in (0.0, 0.004, 0.03, 0.09, 0.2):
        clock = Restless()
        clock.step = step
        assert len(taken(clock, 10)) > 10


def test_the_pace_is_kept_whatever_a_picture_takes():
    assert abs(len(taken(Restless(), 10)) - 100) <= 2
    assert abs(len(taken(Restless(), 10, grab_s=0.05)) - 100) <= 2
    slow = taken(Restless(), 10, grab_s=0.5)
    assert 15 <= len(slow) <= 20, "late pictures are not made up for in a burst"


@pytest.mark.parametrize(("level", "pictures"), [(1, 50), (2, 20), (ONLY_STILLS, 0)])
def test_pictures_become_rarer_the_busier_the_machine_is(level, pictures):
    assert abs(len(taken(Restless(), 10, level=level)) - pictures) <= 1


def test_the_watch_feels_how_late_it_wakes(tmp_path):
    class Late(FakeClock):
        def sleep(self, seconds):
            super().sleep(seconds + 0.3)

    clock, brownout = Late(), Brownout()
    owned, end = SimpleNamespace(clock=clock, running=True, driver=SimpleNamespace(latest=lambda: None)), clock.t + 10

    class Paced:
        def stir(self):
            pass

        def sleep(self, lively_s, idle_s):
            clock.sleep(lively_s)
            owned.running = clock.t < end
            return lively_s

    authority = SimpleNamespace(latch=SimpleNamespace(latched=False))
    lane = SimpleNamespace(
        sound=False, busy=False, current=None, name="motion", lease=SimpleNamespace(lost=False, valid=True),
        pace=Paced(), gate=SimpleNamespace(authority=authority, forbidden=False),
    )  # fmt: skip
    watch = Watch(owned, (lane,), SimpleNamespace(end_reason=""), brownout, tmp_path / "beat", lambda: None)
    watch.loop()
    assert brownout.level == ONLY_STILLS
