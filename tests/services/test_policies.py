"""Motions that go on without a connection or near the end of a grant: the owner's gate and watch on a test clock."""

import threading
from dataclasses import replace
from datetime import timedelta

import pytest

from robots import services
from robots.kit.contract.errors import MotionHeld
from robots.kit.contract.session import Outcome
from robots.models import Grant
from tests.services.owner import Arm, begun, followed, made_owner
from tests.waiting import CEILING_S, wait_for
from workers.authority.gate import LinkDown

pytestmark = [
    pytest.mark.service, pytest.mark.django_db(transaction=True), pytest.mark.usefixtures("installed"),
    pytest.mark.parametrize("which", ["turntable"], indirect=True),
]  # fmt: skip
STEP_S = 0.05


class Table(Arm):
    """It turns until it is held or told to end, and says the angle that the test wants."""

    def __init__(self, clock):
        super().__init__()
        self.clock = clock
        self.angle, self.age_s, self.holds = 0.5, 0.0, 0
        self.moving, self.rest, self.held = threading.Event(), threading.Event(), False

    def latest(self):
        at = self.clock.t - self.age_s
        return replace(super().latest(), at=at, joints=(self.angle,), moving=not self.rest.is_set())

    state = latest

    def hold(self):
        self.holds, self.held = self.holds + 1, True
        self.rest.set()
        return self.latest()

    def execute(self, kind, args, permit, on_stage):
        permit()
        on_stage("sent")
        on_stage("acknowledged")
        self.moving.set()
        assert self.rest.wait(CEILING_S)
        if self.held:
            raise MotionHeld("It was held.")
        permit()
        return Outcome({}, self.latest())


@pytest.fixture
def owner(robot, people):
    made = made_owner(robot, people)
    made.owned.driver = Table(made.clock)
    return made


@pytest.fixture
def start(owner, people):
    """Start a motion in a thread of its own; return its row and that thread."""
    threads = []

    def made(kind, **args):
        robot = owner.owned.robot
        command = services.issue(robot.slug, people["ada"], kind, args, 1, owner.owned.now()).command
        threads.append(begun(owner.motion.run_due))
        assert owner.owned.driver.moving.wait(CEILING_S)
        return command

    yield made
    owner.owned.driver.rest.set()
    for thread in threads:
        thread.join(CEILING_S)


def watched(owner, seconds, link):
    """Let time pass as the owner's loops see it; return after how many seconds the robot was held, or None."""
    begun = owner.clock.t
    while owner.clock.t < begun + seconds:
        owner.clock.go(STEP_S)
        owner.lease.renew()
        if link:
            owner.link.note_answer()
        owner.watch._hold_what_is_forbidden(owner.lane)
        if owner.owned.driver.holds:
            return owner.clock.t - begun
    return None


def gone_s(owner):
    return owner.link._gone_s


def test_a_kind_that_declares_nothing_is_held_as_soon_as_the_connection_is_lost(owner, start):
    start("turn", angle=1.0)
    assert watched(owner, 10.0, link=False) == pytest.approx(gone_s(owner), abs=2 * STEP_S)


def test_a_kind_with_a_bound_goes_on_for_its_seconds_and_no_longer(owner, start):
    start("tour", stops=3)
    assert watched(owner, 20.0, link=False) == pytest.approx(gone_s(owner) + 5.0, abs=2 * STEP_S)


def test_it_ends_well_where_it_arrives_inside_the_bound(owner, start):
    command = start("tour", stops=3)
    assert watched(owner, gone_s(owner) + 3.0, link=False) is None
    owner.owned.driver.rest.set()

    def ended():
        command.refresh_from_db()
        return command.final and owner.lane.current is None

    wait_for(ended, CEILING_S, "its end")
    assert (command.state, owner.owned.driver.holds) == ("completed", 0)
    with pytest.raises(LinkDown):  # and nothing begins after it
        owner.lane.gate.check()


@pytest.mark.parametrize("leaves", [{"angle": 3.2}, {"angle": float("nan")}, {"age_s": 1.5}])
def test_outside_its_area_or_unknown_it_is_held_at_once(owner, start, leaves):
    start("tour", stops=3)
    assert watched(owner, gone_s(owner) + 1.0, link=False) is None
    vars(owner.owned.driver).update(leaves)
    assert watched(owner, 5.0, link=False) == pytest.approx(STEP_S)


def test_the_end_of_the_grant_comes_before_the_end_of_the_bound(owner, start):
    start("tour", stops=3)
    until = owner.owned.now() + timedelta(seconds=gone_s(owner) + 1.0)
    Grant.objects.filter(ended_at=None).update(until=until)
    owner.follower.follow_grant()
    assert watched(owner, 10.0, link=False) == pytest.approx(gone_s(owner) + 1.0, abs=2 * STEP_S)


def test_a_grant_that_is_ended_early_is_the_end_whatever_was_declared(owner, start):
    command = start("tour", stops=3)
    assert watched(owner, gone_s(owner) + 1.0, link=False) is None
    services.end_grant(services.open_grant(owner.owned.robot), "holder", "test", owner.owned.now())
    owner.follower.follow_grant()
    assert command.grant_id in owner.grants.ended_ids
    assert watched(owner, 5.0, link=False) == pytest.approx(STEP_S)


@pytest.mark.parametrize(("angle", "held_s"), [(0.5, 10.0), (3.2, 8.0)])
def test_towards_the_end_of_its_grant_it_goes_on_inside_the_bound_only(owner, start, angle, held_s):
    start("tour", stops=3)
    owner.owned.driver.angle = angle
    Grant.objects.filter(ended_at=None).update(until=owner.owned.now() + timedelta(seconds=10.0))
    owner.follower.follow_grant()
    assert watched(owner, 20.0, link=True) == pytest.approx(held_s, abs=2 * STEP_S)


def test_a_stop_in_the_row_still_reaches_a_robot_that_goes_on(owner, start):
    start("tour", stops=3)
    assert watched(owner, gone_s(owner) + 1.0, link=False) is None
    type(owner.owned.robot).objects.update(stop_latched=True)
    followed(owner)
    assert owner.owned.driver.holds == 1
    owner.latch.release()
