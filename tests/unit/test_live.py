"""The loop of a camera keeps its pace by one reading of the clock a round."""

from types import SimpleNamespace

from robots.brownout import Brownout
from tests.conftest import FakeClock
from workers.cameras.live import send_live


class Restless(FakeClock):
    """A busy machine's clock: every look at it takes time; sleeping less than nothing raises, as time.sleep does."""

    step = 0.0

    def monotonic(self):
        self.t += self.step
        return self.t

    def sleep(self, seconds):
        if seconds < 0:
            raise ValueError("sleep length must be non-negative")
        super().sleep(seconds)


def taken(clock, seconds, grab_s=0.0, every_s=0.1):
    """Return when pictures were taken."""
    at, end = [], clock.t + seconds

    def live_once(state, camera):
        at.append(clock.t)
        clock.t += grab_s
        owned.running = clock.t < end
        return True

    owned = SimpleNamespace(clock=clock, running=True, driver=SimpleNamespace(latest=lambda: None))
    send_live(owned, SimpleNamespace(every_s=every_s, live_once=live_once), Brownout())
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
