"""Turns: join, offer, accept, end; and a machine that tries everything in any order."""

from datetime import timedelta

import pytest
from django.db import IntegrityError, transaction

from portal.web.classic.models import fresh_token, spend_token
from queueing import services as queue
from queueing.errors import NotCleared, NotYourTurn, RobotUnavailable
from queueing.estimates import place_and_wait
from queueing.models import Account, Queue, Ticket, TicketState, Turn
from robots.models import Grant, Lease, Robot
from robots.states import Cycle, GrantEnd
from tests.services.turns import drive

pytestmark = [pytest.mark.service, pytest.mark.django_db]


@pytest.fixture
def now(clock):
    return clock.now()


@pytest.fixture
def stage(robot, people, clock):
    """A robot with a live worker by the fake clock, and the cast."""
    Lease.objects.update_or_create(robot=robot, defaults={"epoch": 1, "expires_at": clock.now() + timedelta(days=99)})
    return robot, people, clock


def hand_over(robot):
    """What the owner does between turns."""
    assert Robot.objects.filter(pk=robot.pk, cycle=Cycle.HANDOVER).update(cycle=Cycle.READY)


def test_the_whole_way_of_a_turn(stage):
    robot, people, clock = stage
    turn = drive(robot, people["ada"], clock.now())
    robot.refresh_from_db()
    assert (robot.cycle, turn.grant.ended_at) == (Cycle.OPERATING, None)
    clock.go(100)
    queue.leave(robot, people["ada"], clock.now())
    turn.refresh_from_db()
    robot.refresh_from_db()
    turn.grant.refresh_from_db()
    assert turn.end_reason == "ended by the operator"
    assert turn.grant.ended_at is not None
    assert turn.charged_s == pytest.approx(100)
    assert robot.cycle == Cycle.HANDOVER
    assert Ticket.objects.get().state == TicketState.DONE


@pytest.mark.asvs("2.3.1")
def test_only_cleared_people_join(stage):
    robot, people, clock = stage
    with pytest.raises(NotCleared):
        queue.join(robot, people["eve"], clock.now())


def test_joining_twice_keeps_one_place(stage):
    robot, people, clock = stage
    first = queue.join(robot, people["ada"], clock.now())
    assert queue.join(robot, people["ada"], clock.go(5)).pk == first.pk
    assert Ticket.objects.count() == 1


def test_the_longest_wait_has_the_time_in_which_the_robot_tidies_up(stage):
    robot, people, clock = stage
    Robot.objects.update(driver="pa10")
    drive(robot, people["ada"], clock.now())
    more = []
    for _ in range(2):  # one hand-over, then that of one more person, too
        waits = []
        for tidy_s in (0, 120):
            Robot.objects.update(settings={"tidy_s": tidy_s})
            robot.refresh_from_db()
            waits.append(queue.wait_if_joined(robot, clock.now()))
        more.append([waits[1][n] - waits[0][n] for n in (0, 1)])
        queue.join(robot, people["bob"], clock.now())
    assert more == [[0, 120], [0, 240]]


def test_an_offer_not_taken_goes_to_the_next(stage):
    robot, people, clock = stage
    queue.join(robot, people["ada"], clock.now())
    queue.join(robot, people["bob"], clock.now())
    queue.tick(clock.now())
    assert queue.open_ticket(robot, people["ada"]).state == TicketState.OFFERED
    with pytest.raises(NotYourTurn):
        queue.accept(robot, people["bob"], clock.now())
    queue.note_presence(robot, people["bob"], clock.go(31))
    queue.tick(clock.now())
    assert queue.open_ticket(robot, people["ada"]) is None
    with pytest.raises(NotYourTurn):
        queue.accept(robot, people["ada"], clock.now())
    assert queue.accept(robot, people["bob"], clock.now()).user == people["bob"]


def test_somebody_absent_is_passed_over_and_keeps_the_place(stage):
    robot, people, clock = stage
    queue.join(robot, people["ada"], clock.now())
    clock.go(100)
    queue.join(robot, people["bob"], clock.now())
    queue.tick(clock.now())
    assert queue.open_ticket(robot, people["bob"]).state == TicketState.OFFERED
    assert queue.open_ticket(robot, people["ada"]).state == TicketState.WAITING


def test_a_turn_goes_on_while_nobody_waits_and_ends_a_minute_after_somebody_joins(stage):
    robot, people, clock = stage
    Robot.objects.update(turn_s=60)
    turn = drive(robot, people["ada"], clock.now())
    for _ in range(30):
        queue.note_presence(robot, people["ada"], clock.go(5))
        queue.tick(clock.now())
    turn.refresh_from_db()
    assert turn.ended_at is None
    assert turn.until > turn.base_until
    queue.join(robot, people["bob"], clock.now())
    turn.refresh_from_db()
    assert turn.until <= clock.now() + timedelta(seconds=60)
    for _ in range(31):
        for name in ("ada", "bob"):
            queue.note_presence(robot, people[name], clock.now())
        queue.tick(clock.go(2))
    turn.refresh_from_db()
    assert turn.end_reason == "time is up"
    used = (turn.ended_at - turn.started_at).total_seconds()
    assert turn.charged_s < used, "time that nobody wanted costs less"


def test_a_lost_line_keeps_the_turn_for_twenty_seconds(stage):
    robot, people, clock = stage
    turn = drive(robot, people["ada"], clock.now())
    queue.note_disconnection(robot, people["ada"], clock.now())
    queue.tick(clock.go(15))
    turn.refresh_from_db()
    assert turn.ended_at is None
    queue.note_presence(robot, people["ada"], clock.now())
    queue.note_disconnection(robot, people["ada"], clock.now())
    queue.tick(clock.go(21))
    turn.refresh_from_db()
    assert turn.end_reason == "connection lost"


def test_a_classic_operator_needs_no_heartbeat_but_requests(stage):
    robot, people, clock = stage
    queue.join(robot, people["ada"], clock.now(), classic=True)
    queue.tick(clock.now())
    ticket = queue.open_ticket(robot, people["ada"])
    assert (ticket.offer_until - clock.now()).total_seconds() == 90
    turn = queue.accept(robot, people["ada"], clock.go(60))
    queue.tick(clock.go(80))
    turn.refresh_from_db()
    assert turn.ended_at is None
    queue.tick(clock.go(11))
    turn.refresh_from_db()
    assert turn.end_reason == "no request came"


@pytest.mark.parametrize(("classic", "limit"), [(False, 120), (True, 180)])
def test_an_idle_operator_ends_when_others_wait(stage, classic, limit):
    robot, people, clock = stage
    turn = drive(robot, people["ada"], clock.now(), classic=classic)
    queue.join(robot, people["bob"], clock.now())
    while (clock.now() - turn.started_at).total_seconds() < limit:
        clock.go(10)
        for name in ("ada", "bob"):
            queue.note_presence(robot, people[name], clock.now())
        queue.tick(clock.now())
        turn.refresh_from_db()
        assert turn.ended_at is None
    for name in ("ada", "bob"):
        queue.note_presence(robot, people[name], clock.now())
    queue.tick(clock.go(10))
    turn.refresh_from_db()
    assert turn.end_reason == "idle while others wait"


def test_a_grant_ended_by_the_owner_ends_the_turn_with_its_reason(stage):
    robot, people, clock = stage
    turn = drive(robot, people["ada"], clock.now())
    Grant.objects.filter(pk=turn.grant_id).update(ended_at=clock.now(), end_reason="time is up")
    queue.tick(clock.now())
    turn.refresh_from_db()
    assert turn.end_reason == "time is up"


def test_health_is_checked_at_offer_and_again_at_start(stage):
    robot, people, clock = stage
    queue.join(robot, people["ada"], clock.now())
    Robot.objects.update(cycle=Cycle.FAULT, reason="no power")
    queue.tick(clock.now())
    assert queue.open_ticket(robot, people["ada"]).state == TicketState.WAITING
    Robot.objects.update(cycle=Cycle.READY, reason="")
    queue.tick(clock.now())
    Lease.objects.update(expires_at=clock.now() - timedelta(seconds=1))
    with pytest.raises(RobotUnavailable, match="worker"):
        queue.accept(robot, people["ada"], clock.now())
    queue.tick(clock.now())
    assert queue.open_ticket(robot, people["ada"]).state == TicketState.WAITING, "the place is kept"


def test_a_paused_queue_offers_nothing_and_keeps_places(stage):
    robot, people, clock = stage
    queue.join(robot, people["ada"], clock.now())
    Queue.objects.update(paused=True)
    queue.tick(clock.now())
    assert queue.open_ticket(robot, people["ada"]).state == TicketState.WAITING


def test_who_has_driven_much_waits_behind_who_has_not(stage):
    robot, people, clock = stage
    drive(robot, people["ada"], clock.now())
    queue.join(robot, people["bob"], clock.go(200))
    queue.leave(robot, people["ada"], clock.now())
    queue.join(robot, people["ada"], clock.now())
    hand_over(robot)
    queue.tick(clock.now())
    assert queue.open_ticket(robot, people["bob"]).state == TicketState.OFFERED
    assert Account.objects.get(user=people["ada"]).finish_tag == pytest.approx(200)


@pytest.mark.asvs("2.3.4")
def test_the_database_itself_refuses_a_second_operator(stage):
    robot, people, clock = stage
    turn = drive(robot, people["ada"], clock.now())
    ticket = queue.join(robot, people["bob"], clock.now())
    other = Robot.objects.create(slug="other", name="Other", address="sim:mercury")
    grant = Grant.objects.create(robot=other, kind="turn", opened_at=clock.now())
    with pytest.raises(IntegrityError), transaction.atomic():
        Turn.objects.create(
            robot=robot, user=people["bob"], ticket=ticket, grant=grant, started_at=clock.now(),
            base_until=turn.until, until=turn.until, last_seen=clock.now(),
        )  # fmt: skip


@pytest.mark.asvs("2.3.4")
def test_a_double_accept_is_one_turn(stage):
    robot, people, clock = stage
    first = drive(robot, people["ada"], clock.now())
    assert queue.accept(robot, people["ada"], clock.now()).pk == first.pk


def test_ending_twice_charges_once(stage):
    robot, people, clock = stage
    turn = drive(robot, people["ada"], clock.now())
    clock.go(50)
    assert queue.end_turn(turn, GrantEnd.STAFF, "one", clock.now())
    assert not queue.end_turn(turn, GrantEnd.STAFF, "two", clock.go(100))
    assert Account.objects.get(user=people["ada"]).finish_tag == pytest.approx(50)


def test_the_wait_is_a_range_or_unknown(stage):
    robot, people, clock = stage
    drive(robot, people["ada"], clock.now())
    ticket = queue.join(robot, people["bob"], clock.now())
    low, high = place_and_wait(robot, ticket, clock.now())[1]
    assert 0 <= low <= high
    assert high >= 300
    robot.cycle = Cycle.FAULT
    assert place_and_wait(robot, ticket, clock.now())[1] is None


def test_a_classic_token_is_good_once_and_spends_its_sisters(stage):
    robot, people, clock = stage
    old, new = (fresh_token(robot, people["ada"], clock.now(), still) for still in (1, 2))
    assert spend_token(robot, people["bob"], new, clock.now()) is None, "a shared address identifies nobody"
    assert spend_token(robot, people["ada"], new, clock.now()) is not None
    assert spend_token(robot, people["ada"], new, clock.now()) is None
    assert spend_token(robot, people["ada"], old, clock.now()) is None


def test_an_open_turn_whose_account_is_gone_keeps_nobody_from_an_offer(stage):
    robot, people, clock = stage
    other = Robot.objects.create(slug="other", name="Other", address="sim:mercury")
    now = clock.now()
    grant = Grant.objects.create(robot=other, kind="turn", opened_at=now)
    Turn.objects.create(robot=other, grant=grant, started_at=now, base_until=now, until=now, last_seen=now)
    queue.join(robot, people["ada"], now)
    queue.tick(now)
    assert Ticket.objects.get().state == TicketState.OFFERED
