"""A lock-out ends only when staff lift it; an error of one robot does not cost another one its queue."""

import threading

import pytest
from django.db import OperationalError, connection, transaction

from accounts.models import Clearance
from queueing import offers, tick
from queueing import services as queue
from queueing.errors import RobotUnavailable
from queueing.models import QueueRobot, Ticket, Turn
from robots import services
from robots.grants import newest_grant_that_moves
from robots.kit.clock import SYSTEM
from robots.kit.contract.errors import NotPermitted
from robots.kit.contract.find import spec_of
from robots.models import Grant, Lease, Robot
from robots.states import Cycle, GrantEnd, GrantKind
from tests.services.owner import begun
from tests.waiting import CEILING_S

pytestmark = [pytest.mark.service, pytest.mark.django_db]


def another(robot, clock, slug="second"):
    """Return a second robot that shares the queue."""
    made = Robot.objects.create(
        slug=slug, name=slug.title(), driver=robot.driver, address=robot.address, enabled=True, cycle=Cycle.READY,
        clearance_required=True,
    )  # fmt: skip
    Lease.objects.create(robot=made, epoch=1, expires_at=clock.now().replace(year=2100))
    QueueRobot.objects.create(robot=made, queue=queue.queue_of(robot))
    return made


def row():
    found = Robot.objects.get(slug="mercury")
    return found.enabled, found.cycle, found.stop_latched, found.lockout_note


def test_switching_off_and_on_lifts_no_lock_out(robot, people):
    services.lock_out(robot, people["kim"], "hands in the cell")
    services.set_enabled(robot, people["kim"], False)
    assert row() == (False, "locked_out", True, "hands in the cell")
    services.set_enabled(robot, people["kim"], True)
    assert row() == (True, "locked_out", True, "hands in the cell")
    services.lift_lock_out(robot, people["kim"])
    assert row() == (True, "handover", True, ""), "the release needs a look at the picture"


def test_a_lift_leaves_a_robot_off_that_is_switched_off(robot, people):
    services.lock_out(robot, people["kim"], "hands in the cell")
    services.set_enabled(robot, people["kim"], False)
    services.lift_lock_out(robot, people["kim"])
    assert row() == (False, "offline", True, "")
    services.set_enabled(robot, people["kim"], True)
    assert row() == (True, "handover", True, "")


def test_only_what_is_locked_out_is_lifted(robot, people):
    with pytest.raises(NotPermitted, match="not locked out"):
        services.lift_lock_out(robot, people["kim"])
    assert row() == (True, "ready", False, ""), "a page that is old stops nobody"


def test_no_turn_begins_on_a_robot_that_is_no_longer_offered(robot, people, owned, clock):
    ticket = queue.join(robot, people["ada"], clock.now())
    queue.tick(clock.now())
    services.lock_out(robot, people["kim"], "hands in the cell")  # after it was found in order
    with pytest.raises(offers.RobotsFault, match="hands in the cell"):
        offers.begin(queue.queue_of(robot), robot, ticket, clock.now())
    assert (row()[1], Turn.objects.count(), Grant.objects.count()) == ("locked_out", 0, 0)


@pytest.mark.django_db(transaction=True)
@pytest.mark.skipif(connection.vendor == "sqlite", reason="SQLite has one writer at a time")
@pytest.mark.parametrize("first", ["accept", "lock-out"])
def test_a_lock_out_at_the_same_moment_wins(robot, people, owned, clock, first):
    queue.join(robot, people["ada"], clock.now())
    queue.tick(clock.now())
    held, locked = threading.Event(), []

    def accept():
        with transaction.atomic():
            try:
                queue.accept(robot, people["ada"], clock.now())
            except RobotUnavailable as error:
                locked.append(str(error))
            held.set()
            SYSTEM.sleep(0.4 if first == "accept" else 0.0)  # not committed yet

    def lock_out():
        with transaction.atomic():
            services.lock_out(robot, people["kim"], "hands in the cell")
            held.set()
            SYSTEM.sleep(0.4 if first == "lock-out" else 0.0)

    one, other = (accept, lock_out) if first == "accept" else (lock_out, accept)
    threads = [begun(one)]
    held.wait(CEILING_S)
    threads.append(begun(other))
    for thread in threads:
        thread.join(CEILING_S)
    assert row()[1] == "locked_out"
    assert not Grant.objects.filter(ended_at=None).exists(), "nobody may move it"
    assert len(locked) == (first == "lock-out")


@pytest.mark.django_db(transaction=True)
@pytest.mark.skipif(connection.vendor == "sqlite", reason="SQLite has one writer at a time")
@pytest.mark.parametrize("closes", ["lock-out", "switch"])
def test_a_robot_is_closed_while_its_grant_is_being_ended(robot, people, owned, clock, closes):
    """The end of a grant writes the robot last; in the other order each of two would wait for the other."""
    grant, ended, failed = (
        services.start_grant(robot, GrantKind.TURN, clock.now(), people["ada"]),
        threading.Event(),
        [],
    )

    def end():
        try:
            with transaction.atomic():
                services.end_grant(grant, GrantEnd.FINISHED, "the turn is over", clock.now())
                ended.set()
                SYSTEM.sleep(0.4)
                Robot.objects.filter(pk=robot.pk).update(reason="to be put in order")
        except OperationalError as error:
            failed.append(error)

    def close():
        try:
            if closes == "switch":
                services.set_enabled(robot, people["kim"], False)
            else:
                services.lock_out(robot, people["kim"], "hands in the cell")
        except OperationalError as error:
            failed.append(error)

    threads = [begun(end)]
    ended.wait(CEILING_S)
    threads.append(begun(close))
    for thread in threads:
        thread.join(CEILING_S)
    assert not failed
    assert row()[1] == ("offline" if closes == "switch" else "locked_out")
    assert Grant.objects.get().end_code == GrantEnd.FINISHED


@pytest.mark.parametrize(
    "fault", [TypeError("no such argument"), ImportError("half a package"), AttributeError("spec")]
)
def test_a_broken_package_is_named(monkeypatch, fault):
    class Broken:
        @staticmethod
        def spec():
            raise fault

    monkeypatch.setattr("robots.kit.contract.find.import_module", lambda name: Broken)
    spec_of.cache_clear()
    with pytest.raises(LookupError, match="package of the driver 'odd' is broken"):
        spec_of("odd")
    monkeypatch.undo()
    spec_of.cache_clear()


def test_an_error_in_one_queue_costs_no_other_its_tick(robot, people, owned, clock, monkeypatch):
    broken = Robot.objects.create(slug="broken", name="Broken", driver="mercury", address="x", enabled=True)
    first = queue.queue_of(broken)
    queue.join(robot, people["ada"], clock.now())
    served = tick._tick

    def fails(one, now, **more):
        if one == first:
            raise TypeError("a package that does something wrong")
        served(one, now, **more)

    monkeypatch.setattr(tick, "_tick", fails)
    queue.tick(clock.now())
    assert Ticket.objects.get().state == "offered"


def test_a_robot_is_offered_only_to_who_may_drive_it(robot, people, owned, clock):
    Robot.objects.filter(pk=robot.pk).update(cycle=Cycle.FAULT)
    other = another(robot, clock)
    queue.join(robot, people["ada"], clock.now())
    queue.join(robot, people["bob"], clock.go(1))
    Clearance.objects.create(user=people["bob"], robot=other, granted_at=clock.now())
    queue.tick(clock.now())
    states = dict(Ticket.objects.values_list("user__username", "state"))
    assert states == {"ada": "waiting", "bob": "offered"}
    assert queue.accept(other, people["bob"], clock.now()).robot == other
    Robot.objects.filter(pk=robot.pk).update(cycle=Cycle.READY)
    queue.tick(clock.go(1))
    assert Ticket.objects.get(user=people["ada"]).robot == robot


@pytest.mark.parametrize("kind", [GrantKind.JOB, GrantKind.IDLE])
def test_a_picture_of_staff_takes_no_handover_from_who_drives_next(robot, people, owned, clock, kind):
    of_itself = services.start_grant(robot, kind, clock.now())
    services.end_grant(of_itself, GrantEnd.FINISHED, "done", clock.now())
    picture = services.start_grant(robot, GrantKind.UPKEEP, clock.go(1), people["kim"])
    services.end_grant(picture, GrantEnd.FINISHED, "done", clock.now())
    assert newest_grant_that_moves(robot) == of_itself
    settings = services.start_grant(robot, GrantKind.SETTINGS, clock.go(1))  # set back at the release of a stop
    services.end_grant(settings, GrantEnd.FINISHED, "done", clock.now())
    assert newest_grant_that_moves(robot) == of_itself
    queue.join(robot, people["ada"], clock.now())
    queue.tick(clock.now())
    assert row()[1] == "handover"
    tidy = services.start_grant(robot, GrantKind.HANDOVER, clock.now())
    services.end_grant(tidy, GrantEnd.FINISHED, "in order", clock.now())
    Robot.objects.filter(pk=robot.pk).update(cycle=Cycle.READY)
    queue.tick(clock.go(1))
    assert row()[1] == "offered"
