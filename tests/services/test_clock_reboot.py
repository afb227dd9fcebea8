"""The machine was off, and rows were written before its first look at the clock."""

from datetime import timedelta

import pytest

from queueing import services as queue
from queueing.models import Ticket, Turn
from queueing.steps import carry
from queueing.tick import ABSENT_S
from robots.kit.clock import SYSTEM
from robots.models import Lease
from robots.wall_clock import WallClock
from tests.conftest import FakeClock
from tests.services.clock_steps import HOUR, drive

pytestmark = [pytest.mark.service, pytest.mark.django_db]

OFF = pytest.mark.parametrize("gap", [10 * HOUR, 40.0, -10 * HOUR], ids=["off for long", "off briefly", "set back"])
BOOT_S = 30.0  # from the start of the machine until the first look


class Boots:
    """A clock whose machine is switched off: `off` takes so long by the time of day; since then it was awake `BOOT_S`."""

    def __init__(self, tmp_path):
        self.at, self.boot, self.began, self.wall = 1000.0, "one", 0.0, 0.0
        self.looks = WallClock(tmp_path / "boots", self, lambda: self.boot)

    def now(self):
        return FakeClock().now() + timedelta(seconds=self.at + self.wall)

    def awake(self):
        return self.at - self.began

    monotonic = awake
    lock = staticmethod(SYSTEM.lock)

    def off(self, gap):
        self.boot, self.began, self.wall = "another", self.at, self.wall + gap

    def go(self, seconds):
        self.at += seconds
        return self.now()

    def look(self):
        return self.looks.follow(carry)


@pytest.fixture
def boots(tmp_path):
    found = Boots(tmp_path)
    found.look()
    return found


@OFF
def test_what_was_written_from_the_start_of_the_machine_on_is_not_moved(robot, people, owned, boots, gap):
    boots.off(gap)
    boots.go(5)
    turn = drive(robot, people, boots)
    queue.join(robot, people["bob"], boots.now())
    written = boots.now()
    boots.go(BOOT_S - 5)
    Lease.objects.update(expires_at=boots.now() + timedelta(seconds=2), state_at=boots.now())
    lease = Lease.objects.get()
    boots.look()
    after = Turn.objects.get()
    assert (after.until, after.last_seen, after.grant.until) == (turn.until, turn.last_seen, turn.grant.until)
    assert Ticket.objects.get(user=people["bob"]).last_seen == written
    assert Lease.objects.get().expires_at == lease.expires_at
    queue.tick(boots.go(ABSENT_S + 1))
    assert Ticket.objects.get(user=people["bob"]).state == "expired", "the page was closed"


@OFF
def test_what_was_open_when_the_machine_went_off_goes_on_at_the_first_look(robot, people, owned, boots, gap):
    turn = drive(robot, people, boots)
    boots.look()
    before = boots.now()
    left, seen = turn.until - before, before - turn.last_seen
    boots.off(gap)
    boots.go(5)
    queue.join(robot, people["bob"], boots.now())
    now = boots.go(BOOT_S - 5)
    assert boots.look() == now
    after = Turn.objects.get()
    assert (after.until - now, now - after.last_seen, after.grant.until) == (left, seen, after.until)
    assert now - Ticket.objects.get(user=people["bob"]).last_seen == timedelta(seconds=BOOT_S - 5)


@OFF
def test_an_offer_that_was_open_when_the_machine_went_off_goes_on(robot, people, owned, boots, gap):
    queue.join(robot, people["ada"], boots.now())
    queue.tick(boots.now())
    boots.look()
    left = Ticket.objects.get().offer_until - boots.now()
    boots.off(gap)
    boots.go(BOOT_S)
    assert boots.look() + left == Ticket.objects.get().offer_until


def test_the_machine_of_the_look_alone_was_off_and_others_turns_go_on(robot, people, owned, boots):
    """The rows that others wrote meanwhile prove that the portal ran."""
    boots.off(10 * HOUR)
    boots.go(-60.0)  # by the clock of another machine
    boots.began = boots.at + 60.0
    turn = drive(robot, people, boots)
    boots.go(60.0 + BOOT_S)
    Turn.objects.update(last_seen=boots.now())
    now = boots.look()
    after = Turn.objects.get()
    assert after.until - turn.until <= timedelta(seconds=60.0 + BOOT_S)
    assert after.last_seen == now, "nothing is written ahead"
