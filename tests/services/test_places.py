"""A person's places on every page: the most urgent one, missed ones, and what counts as presence."""

from datetime import timedelta

import pytest
from django.conf import settings
from django.db.models.signals import post_save

from accounts.models import Clearance
from portal.live.standing import act
from queueing import services as queue
from queueing.models import PlaceEnd, QueueRobot, Ticket, TicketState, Turn
from queueing.services import dismiss, note_waiting, standings
from queueing.words import PLACE_ENDS
from robots.models import Lease, Robot
from robots.states import Cycle
from tests.services.turns import drive

pytestmark = [pytest.mark.service, pytest.mark.django_db]
RULES = settings.FARHAND


@pytest.fixture
def stage(robot, people, clock):
    alive(robot, clock)
    return robot, people, clock


def alive(robot, clock):
    Lease.objects.update_or_create(robot=robot, defaults={"epoch": 1, "expires_at": clock.now() + timedelta(days=99)})


def states(user, clock):
    return [(s.state, s.robot.slug) for s in standings(user, clock.now())]


def another(people, clock):
    other = Robot.objects.create(
        slug="other", name="Other", driver="mercury", address="sim:x", enabled=True, cycle=Cycle.READY
    )
    queue.queue_of(other)
    alive(other, clock)
    for name in ("ada", "bob"):
        Clearance.objects.create(user=people[name], robot=other, granted_at=clock.now())
    return other


def test_nobody_and_who_has_nothing_stand_nowhere(stage):
    from django.contrib.auth.models import AnonymousUser

    _, people, clock = stage
    assert standings(AnonymousUser(), clock.now()) == []
    assert standings(people["ada"], clock.now()) == []


def test_waiting_offered_operating(stage):
    robot, people, clock = stage
    queue.join(robot, people["ada"], clock.now())
    queue.join(robot, people["bob"], clock.now())
    [bob] = standings(people["bob"], clock.now())
    assert (bob.state, bob.ahead) == ("waiting", 1)
    assert bob.wait_s is not None
    queue.tick(clock.now())
    [ada] = standings(people["ada"], clock.now())
    assert (ada.state, ada.until) == ("offered", clock.now() + timedelta(seconds=RULES["OFFER_S"]))
    turn = queue.accept(robot, people["ada"], clock.now())
    [ada] = standings(people["ada"], clock.now())
    assert (ada.state, ada.until, ada.kept_until) == ("operating", turn.until, None)
    queue.note_disconnection(robot, people["ada"], clock.now())
    [ada] = standings(people["ada"], clock.now())
    assert ada.kept_until == clock.now() + timedelta(seconds=RULES["RECONNECT_S"])
    queue.note_presence(robot, people["ada"], clock.go(3))
    assert standings(people["ada"], clock.now())[0].kept_until is None


def test_a_presence_that_is_noted_late_undoes_no_absence_after_it(stage):
    """The operator's page has two sockets and a thread for each note: a note may come after a younger one."""
    robot, people, clock = stage
    drive(robot, people["ada"], clock.now())
    pinged = clock.go(2)
    queue.note_disconnection(robot, people["ada"], left := clock.go(0.1))
    queue.note_presence(robot, people["ada"], pinged)
    assert Turn.objects.values_list("connected", "last_seen").get() == (False, left)
    queue.note_presence(robot, people["ada"], back := clock.go(1))
    assert Turn.objects.values_list("connected", "last_seen").get() == (True, back)


def test_a_turn_that_is_accepted_on_another_page_begins_without_its_robots_page(stage, request):
    robot, people, clock = stage
    queue.join(robot, people["ada"], clock.now())
    queue.tick(clock.now())
    begun = []

    def created(instance, **_):
        begun.append(instance.connected)

    post_save.connect(created, sender=Turn)
    request.addfinalizer(lambda: post_save.disconnect(created, sender=Turn))
    assert act(people["ada"], "accept", robot.slug, 0, clock.now()) == ""
    assert begun == [False], "no other page is told that the robot's page is open"
    assert standings(people["ada"], clock.now())[0].kept_until == clock.now() + timedelta(seconds=RULES["RECONNECT_S"])
    queue.note_presence(robot, people["ada"], clock.go(1))
    assert act(people["ada"], "accept", robot.slug, 0, clock.now()) == "", "a second click"
    assert standings(people["ada"], clock.now())[0].kept_until is None, "the robot's page is open meanwhile"


def test_the_most_urgent_comes_first(stage):
    robot, people, clock = stage
    other = another(people, clock)
    queue.join(other, people["bob"], clock.now())
    queue.join(other, people["ada"], clock.now())
    queue.join(robot, people["ada"], clock.now())
    queue.tick(clock.now())
    assert states(people["ada"], clock) == [("offered", robot.slug), ("waiting", "other")]


@pytest.mark.asvs("8.2.2")
def test_a_missed_offer_is_told_until_it_is_dismissed_by_its_owner(stage):
    robot, people, clock = stage
    ticket = queue.join(robot, people["ada"], clock.now())
    queue.tick(clock.now())
    queue.tick(clock.go(RULES["OFFER_S"] + 1))
    [missed] = standings(people["ada"], clock.go(86_400))
    assert (missed.state, missed.ticket, missed.end) == ("missed", ticket.pk, PLACE_ENDS[PlaceEnd.NO_ANSWER])
    dismiss(ticket.pk, people["bob"], clock.now())
    assert states(people["ada"], clock) == [("missed", robot.slug)]
    dismiss(ticket.pk, people["ada"], clock.now())
    assert states(people["ada"], clock) == []


def test_who_joins_again_is_told_of_the_new_place_alone(stage):
    robot, people, clock = stage
    queue.join(robot, people["ada"], clock.now())
    queue.tick(clock.now())
    queue.tick(clock.go(RULES["OFFER_S"] + 1))
    queue.join(robot, people["ada"], clock.now())
    assert states(people["ada"], clock) == [("waiting", robot.slug)]
    queue.leave(robot, people["ada"], clock.now())
    assert states(people["ada"], clock) == [], "who left knows it"


def test_only_an_expired_place_can_be_dismissed(stage):
    robot, people, clock = stage
    ticket = queue.join(robot, people["ada"], clock.now())
    dismiss(ticket.pk, people["ada"], clock.now())
    ticket.refresh_from_db()
    assert (ticket.state, ticket.dismissed_at) == (TicketState.WAITING, None)


def test_who_reads_another_page_is_present_and_gets_the_offer(stage):
    robot, people, clock = stage
    queue.join(robot, people["ada"], clock.now())
    Robot.objects.filter(pk=robot.pk).update(cycle=Cycle.HANDOVER)
    for _ in range(20):
        note_waiting(people["ada"], clock.go(60))
        queue.tick(clock.now())
    Robot.objects.filter(pk=robot.pk).update(cycle=Cycle.READY)
    queue.tick(clock.go(1))
    assert states(people["ada"], clock) == [("offered", robot.slug)]


@pytest.mark.asvs("2.3.2")
def test_a_sign_of_life_from_elsewhere_lengthens_no_turn_and_nobody_elses_place(stage):
    robot, people, clock = stage
    drive(robot, people["ada"], clock.now())
    queue.join(robot, people["bob"], clock.now())
    queue.note_disconnection(robot, people["ada"], clock.now())
    before = Ticket.objects.get(user=people["bob"]).last_seen
    for _ in range(5):
        note_waiting(people["ada"], clock.go(5))
        queue.tick(clock.now())
    assert Turn.objects.get(user=people["ada"]).end_reason == "connection lost"
    assert Ticket.objects.get(user=people["bob"]).last_seen == before


@pytest.mark.parametrize("state", ["waiting", "operating"])
def test_a_place_at_a_robot_that_was_deleted_fails_no_page(stage, state):
    robot, people, clock = stage
    QueueRobot.objects.filter(robot=another(people, clock)).update(queue=queue.queue_of(robot))
    queue.join(robot, people["ada"], clock.now())
    if state == "operating":
        queue.tick(clock.now())
        queue.accept(robot, people["ada"], clock.now())
    robot.delete()
    assert states(people["ada"], clock) == ([("waiting", "other")] if state == "waiting" else [])
