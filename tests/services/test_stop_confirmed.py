"""A stop is confirmed by the robot alone; until then it is shown as not confirmed, with the time by which it rests."""

from dataclasses import replace
from datetime import timedelta

import pytest
from django.contrib.auth.models import AnonymousUser
from django.template.loader import render_to_string

from portal.live.snapshot import snapshot
from robots import services
from robots.kit.contract.errors import LineGone
from robots.models import Incident, Lease, Robot
from tests.services.owner import Arm, followed, made_owner
from workers.authority.memory import StopLatch

pytestmark = [
    pytest.mark.service, pytest.mark.django_db(transaction=True), pytest.mark.parametrize("which", ["pa10"], indirect=True),
]  # fmt: skip
REST_S = 13.0


class Wire(Arm):
    """A driver whose wire can be pulled: it hears nothing then, and nobody hears it."""

    def __init__(self, clock):
        super().__init__()
        self.clock = clock
        self.pulled, self.moving, self.newest = False, True, None

    def state(self):
        if self.pulled:
            raise LineGone("The arm does not answer.")
        self.newest = replace(super().latest(), at=self.clock.t, moving=self.moving)
        return self.newest

    def latest(self):
        return self.newest

    def hold(self):
        self.holds += 1
        if not self.pulled:
            self.moving = False
        return self.state()


@pytest.fixture
def owner(robot, people):
    made = made_owner(robot, people)
    made.owned.driver = Wire(made.clock)
    made.owned.driver.state()
    return made


def shown(owner, viewer=None):
    return snapshot(owner.owned.robot.slug, viewer or AnonymousUser(), owner.owned.now(), True)["stop"]


def press(owner, people):
    services.stop(owner.owned.robot, people["ada"], owner.owned.now())
    followed(owner)  # the bus or the row: both end here
    followed(owner)


def test_a_stop_that_the_robot_answers_is_confirmed(owner, people):
    assert shown(owner) is None
    press(owner, people)
    assert (shown(owner)["confirmed"], shown(owner)["rests_by_ms"]) == (True, None)
    assert not owner.owned.driver.moving


def test_a_stop_holds_and_is_kept_where_the_system_has_no_thread_left(owner, people, monkeypatch):
    def refuse(thread):
        raise RuntimeError("can't start new thread")

    with monkeypatch.context() as without:
        without.setattr("threading.Thread.start", refuse)
        owner.stopping.halt("bus")
    assert not owner.owned.driver.moving
    assert StopLatch(owner.latch._path).latched, "it is on the disk"


def test_between_the_press_and_the_owner_nothing_is_confirmed(owner, people):
    services.stop(owner.owned.robot, people["ada"], owner.owned.now())
    assert shown(owner)["confirmed"] is False


def test_with_the_wire_pulled_it_is_not_and_says_by_when_the_robot_rests(owner, people):
    wire, pressed = owner.owned.driver, owner.owned.now()
    wire.pulled = True
    press(owner, people)
    now = shown(owner)
    assert now["confirmed"] is False
    assert now["rests_by_ms"] == int((pressed + timedelta(seconds=REST_S)).timestamp() * 1000)
    assert Incident.objects.filter(code="stop_failed").exists()
    owner.clock.go(2.0)
    owner.stopping.halt("bus")  # pressed again: an earlier hold that failed is what counts
    followed(owner)
    assert shown(owner)["rests_by_ms"] == now["rests_by_ms"]
    wire.pulled = False
    wire.state()  # it answers again, and moves
    followed(owner)
    assert (shown(owner)["confirmed"], shown(owner)["rests_by_ms"], wire.moving) == (True, None, False)


def test_an_owner_that_starts_with_a_stop_latched_holds_and_confirms(owner, people):
    wire = owner.owned.driver
    wire.pulled = True
    press(owner, people)
    Robot.objects.update(rests_by=None)
    owner.stopping.__init__(owner.owned, owner.latch)  # as a new process finds the latch
    followed(owner)
    assert shown(owner)["confirmed"] is False
    wire.pulled = False
    owner.clock.go(0.1)
    wire.state()
    followed(owner)
    assert (shown(owner)["confirmed"], wire.moving) == (True, False)


def test_an_owner_that_starts_with_a_stop_latched_and_reaches_no_robot_says_by_when_it_rests(owner, people):
    owner.owned.driver.pulled = True
    services.stop(owner.owned.robot, people["ada"], owner.owned.now())
    owner.clock.go(5.0)  # until a new owner has the lease of the one that was killed
    owner.stopping.begin()
    began = owner.owned.now()
    owner.stopping.follow()
    assert shown(owner)["confirmed"] is False
    assert shown(owner)["rests_by_ms"] == int((began + timedelta(seconds=REST_S)).timestamp() * 1000)


def test_the_time_of_a_stop_that_was_released_unconfirmed_is_not_said_of_the_next(owner, people):
    owner.owned.driver.pulled = True
    press(owner, people)
    assert shown(owner)["rests_by_ms"]
    services.release_stop(owner.owned.robot, people["ada"], checked=True)
    followed(owner)
    owner.clock.go(60.0)
    Lease.objects.update(expires_at=owner.owned.now() + timedelta(seconds=3))
    services.stop(owner.owned.robot, people["ada"], owner.owned.now())
    assert (shown(owner)["confirmed"], shown(owner)["rests_by_ms"]) == (False, None)


def test_a_second_press_takes_nothing_back_and_the_next_stop_begins_anew(owner, people):
    press(owner, people)
    services.stop(owner.owned.robot, people["ada"], owner.owned.now())
    assert shown(owner)["confirmed"] is True
    services.release_stop(owner.owned.robot, people["ada"], checked=True)
    followed(owner)
    assert (shown(owner), owner.latch.latched) == (None, False)
    owner.owned.driver.pulled = True
    services.stop(owner.owned.robot, people["ada"], owner.owned.now())
    assert shown(owner)["confirmed"] is False


def test_without_an_owner_it_rests_by_itself_after_the_time_that_its_spec_names(owner, people):
    Lease.objects.update(expires_at=owner.owned.now() - timedelta(seconds=5))
    services.stop(owner.owned.robot, people["ada"], owner.owned.now())
    assert shown(owner)["rests_by_ms"] == int((owner.owned.now() + timedelta(seconds=REST_S)).timestamp() * 1000)


@pytest.mark.parametrize("rests", [True, False])
def test_staff_read_it_in_the_admin(owner, people, rests):
    owner.owned.driver.pulled = not rests
    press(owner, people)
    robot = Robot.objects.get()
    page = render_to_string(
        "admin/robots/robot/status.html", {"robot": robot, "stop": services.stop_shown(robot, owner.owned.now())}
    )
    assert ("<b>stopped</b>" in page) is rests
    assert ("has not said that it rests; it rests by" in page) is not rests


@pytest.mark.parametrize(("seconds", "overdue"), [(0.0, False), (0.9, False), (1.1, True)])
def test_a_confirmation_that_is_under_way_is_no_news(owner, people, seconds, overdue):
    now = owner.owned.now()
    services.stop(owner.owned.robot, people["ada"], now)
    assert services.stop_shown(Robot.objects.get(), now + timedelta(seconds=seconds)).overdue is overdue


def test_a_press_during_the_hold_that_a_release_waits_for_is_not_released(owner, people):
    owner.stopping.begin()
    owner.owned.driver.pulled = True
    press(owner, people)
    services.release_stop(owner.owned.robot, people["ada"], checked=True)
    stopping, ours = owner.stopping, owner.stopping._halting

    class Held:
        """The lock that `follow` waits for: before it gets it, somebody presses."""

        def __enter__(self):
            stopping._halting = ours
            stopping.halt("bus")
            return ours.__enter__()

        def __exit__(self, *failed):
            return ours.__exit__(*failed)

    stopping._halting = Held()
    stopping.follow()
    assert owner.latch.latched
    stopping.follow()
    assert Robot.objects.get().stop_latched
