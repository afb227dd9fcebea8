"""A robot's owner while the time of day is set or the machine sleeps: no turn is shorter or longer, no lease is taken."""

import socket
from datetime import timedelta

import pytest
from django.db.models import F

from queueing.steps import carry
from robots import services
from robots.models import Command, Grant, Lease
from robots.wall_clock import WallClock
from tests.services.clock_steps import each_change, each_step
from tests.services.owner import made_owner
from workers.authority.lease import OwnerLease
from workers.guard.follow import LATE_S

pytestmark = pytest.mark.django_db


@pytest.fixture
def owner(robot, people):
    made = made_owner(robot, people)
    yield made
    made.lease.give_back()


@each_change
def test_an_owner_lets_the_turn_move_the_robot_for_its_time_and_not_longer(owner, tmp_path, change):
    clock, gate = owner.clock, owner.lane.gate
    looks = WallClock(tmp_path / "clock", clock)
    looks.follow(carry)
    owner.follower.follow_grant()
    gate.open_for(services.open_grant(owner.owned.robot))

    def may():
        owner.lease._until = clock.monotonic() + 3  # renewed
        owner.lease._lapsed = False
        owner.link.note_answer()
        owner.follower.follow_grant()
        return not gate.forbidden and Grant.objects.get().ended_at is None

    clock.go(20)
    change(clock)
    assert may(), "before anybody has looked at the clocks"
    looks.follow(carry)
    gate.open_for(services.open_grant(owner.owned.robot))
    clock.go(39.5)
    assert may()
    clock.go(0.6)
    assert not may()
    assert gate.forbidden
    clock.go(LATE_S)
    assert not may()
    assert Grant.objects.get().end_code == "time_up"


def ends_late(owner):
    """Nobody has ended the turn, whose time is up: the owner does."""
    assert owner.grants.over(Grant.objects.get().pk)
    owner.clock.go(LATE_S)
    owner.follower.follow_grant()
    assert Grant.objects.get().end_code == "time_up"


@each_change
def test_an_owner_ends_the_turn_in_time_also_if_nobody_looks_at_the_clocks(owner, change):
    owner.follower.follow_grant()
    change(owner.clock)
    owner.clock.go(59)
    owner.follower.follow_grant()
    assert Grant.objects.get().ended_at is None
    owner.clock.go(1.5)
    ends_late(owner)


@each_step
def test_an_owner_that_sees_a_turn_for_the_first_time_after_a_step_ends_it_neither_early_nor_late(owner, by):
    """Nobody has looked at the clocks yet; then somebody does, or nobody at all."""
    owner.clock.step(by)
    owner.follower.follow_grant()
    assert Grant.objects.get().ended_at is None
    left_s = owner.grants.until(Grant.objects.get().pk) - owner.clock.monotonic()
    assert left_s <= 60
    Grant.objects.update(until=F("until") + timedelta(seconds=by), opened_at=F("opened_at") + timedelta(seconds=by))
    owner.follower.follow_grant()
    owner.clock.go(59)
    owner.link.note_answer()
    owner.follower.follow_grant()
    assert not owner.grants.over(Grant.objects.get().pk)
    owner.clock.go(1.5)
    owner.follower.follow_grant()
    ends_late(owner)


@each_step
def test_an_owner_that_sees_a_turn_late_ends_it_also_if_nobody_looks_at_the_clocks(owner, by):
    owner.clock.step(by)
    for _ in range(65):
        owner.follower.follow_grant()
        owner.clock.go(1)
    assert Grant.objects.get().end_code == "time_up"


@each_step
def test_an_extension_adds_what_it_says_and_no_step(owner, by):
    """The row is extended after the step, before anybody has looked at the clocks: it can be too short, never longer."""
    owner.follower.follow_grant()
    owner.clock.step(by)
    Grant.objects.update(until=F("until") + timedelta(seconds=10))
    owner.follower.follow_grant()
    owner.clock.go(70.5)
    assert owner.grants.over(Grant.objects.get().pk)
    owner.clock.go(LATE_S)
    owner.follower.follow_grant()
    assert Grant.objects.get().ended_at is not None


@each_step
def test_a_command_of_before_the_step_begins_no_later_than_it_may(owner, by):
    now = owner.clock.now()
    waits = Command(created_at=now, deadline=now + timedelta(seconds=5))
    owner.lane.gate.expect(waits, owner.clock.step(by))
    assert owner.lane.gate.begin_by <= owner.clock.monotonic() + 5


@pytest.fixture
def others(robot, clock, tmp_path):
    """The lease of an owner on another host, which renews it, and a second one here that waits for it."""
    Lease.objects.update_or_create(robot=robot, defaults={"epoch": 7, "host": "elsewhere", "pid": 4, "started": "1"})

    def renew():
        Lease.objects.update(expires_at=clock.now() + timedelta(seconds=3))

    renew()
    waits = OwnerLease(robot, tmp_path / "lock", clock)
    waits.measure_offset = lambda: None
    yield waits, renew
    waits.give_back()


@each_change
def test_a_second_owner_takes_no_lease_that_is_renewed(others, clock, change):
    waits, renew = others
    for n in range(20):
        if n == 8:
            change(clock)
        assert not waits._try(), n
        clock.go(0.25)
        if n % 3 == 2:
            renew()


@each_change
def test_the_lease_of_an_owner_that_has_died_is_taken_after_its_length(others, clock, change):
    waits, _ = others
    assert not waits._try()
    change(clock)
    taken = False
    for _ in range(13):
        clock.go(0.25)
        taken = taken or (waits._try() and waits.valid)
    assert taken


@pytest.mark.service
def test_the_lease_of_a_process_of_this_host_that_has_ended_is_taken_as_soon_as_it_is_over(others, clock):
    waits, _ = others
    Lease.objects.update(host=socket.gethostname(), pid=2**22 + 5)
    clock.go(2.9)
    assert not waits._try()
    clock.go(0.2)
    assert waits._try()
