"""People who need more time have longer turns: staff set it, all times and estimates follow, and nobody else is told."""

from datetime import timedelta

import pytest
from django.contrib.auth.models import AnonymousUser
from django.db import IntegrityError, transaction
from django.test import Client

from accounts.models import Clearance, User
from portal.live.snapshot import snapshot
from queueing import services as queue
from queueing.models import Account, QueueRobot, Ticket, TicketState, Turn
from robots.models import Lease, Robot
from robots.states import Cycle, GrantEnd
from tests.services.test_admin_rights import filled, page, staff
from tests.services.turns import drive

pytestmark = [pytest.mark.service, pytest.mark.django_db]


@pytest.fixture
def stage(robot, people, clock):
    """A robot with a live worker by the fake clock, and ada, whose turns are twice as long."""
    Lease.objects.update_or_create(robot=robot, defaults={"epoch": 1, "expires_at": clock.now() + timedelta(days=99)})
    longer(people["ada"], 2)
    return robot, people, clock


def longer(person, times):
    person.turn_factor = times
    person.save(update_fields=["turn_factor"])


def ticks(robot, people, clock, seconds, each_s=5):
    """Let time pass; everybody stays present."""
    for _ in range(int(seconds / each_s)):
        clock.go(each_s)
        for person in people:
            queue.note_presence(robot, person, clock.now())
        queue.tick(clock.now())


def test_turn_and_offer_last_as_many_times_as_long(stage):
    robot, people, clock = stage
    queue.join(robot, people["ada"], clock.now())
    queue.tick(clock.now())
    assert Ticket.objects.get().offer_until == clock.now() + timedelta(seconds=60)
    ticks(robot, [people["ada"]], clock, 55)
    turn = queue.accept(robot, people["ada"], clock.now())
    assert turn.until == turn.base_until == turn.grant.until == clock.now() + timedelta(seconds=600)
    Turn.objects.update(ended_at=clock.now())
    Ticket.objects.update(state=TicketState.DONE)
    Robot.objects.update(cycle=Cycle.READY)
    turn.grant.__class__.objects.update(ended_at=clock.now())
    usual = drive(robot, people["bob"], clock.now())
    assert usual.until == clock.now() + timedelta(seconds=300)


def test_an_offer_that_is_not_answered_in_the_longer_time_is_over(stage):
    robot, people, clock = stage
    queue.join(robot, people["ada"], clock.now())
    queue.tick(clock.now())
    ticks(robot, [people["ada"]], clock, 65)
    assert Ticket.objects.get().state == TicketState.EXPIRED


def test_a_turn_without_acts_ends_as_many_times_later_and_says_so(stage):
    robot, people, clock = stage
    turn = drive(robot, people["ada"], clock.now())
    queue.join(robot, people["bob"], clock.now())
    assert queue.idle_at(turn, clock.now()) == clock.now() + timedelta(seconds=240)
    ticks(robot, [people["ada"], people["bob"]], clock, 235)
    assert Turn.objects.get().ended_at is None
    ticks(robot, [people["ada"], people["bob"]], clock, 15)
    ended = Turn.objects.get()
    assert ended.grant.end_code == GrantEnd.IDLE
    assert queue.end_of_turn(ended).why == "Nothing was done for 4 min while others waited."


def test_after_somebody_comes_extra_time_ends_as_many_times_later(stage):
    robot, people, clock = stage
    drive(robot, people["ada"], clock.now())
    ticks(robot, [people["ada"]], clock, 615, each_s=15)
    assert Turn.objects.get().until > Turn.objects.get().base_until, "nobody waits"
    Turn.objects.update(until=clock.now() + timedelta(seconds=900))
    queue.join(robot, people["bob"], clock.now())
    assert Turn.objects.get().until == clock.now() + timedelta(seconds=120)


def test_it_costs_as_much_in_the_queue_as_a_usual_turn(stage):
    robot, people, clock = stage
    turn = drive(robot, people["ada"], clock.now())
    queue.end_turn(turn, GrantEnd.FINISHED, "", clock.go(600))
    assert Account.objects.get(user=people["ada"]).finish_tag == pytest.approx(300)
    assert Turn.objects.get().charged_s == pytest.approx(600)


def test_who_waits_behind_longer_turns_waits_within_the_estimate(stage):
    robot, people, clock = stage
    longer(people["mod"], 4)
    Robot.objects.update(turn_s=60)
    robot.refresh_from_db()
    for name in ("mod", "kim"):
        Clearance.objects.create(user=people[name], robot=robot, granted_at=clock.now())
    behind = [people["ada"], people["mod"], people["bob"]]
    drive(robot, people["kim"], clock.now())
    for person in behind:
        queue.join(robot, person, clock.go(1))
    place = queue.open_ticket(robot, people["bob"])
    low, high = queue.place_and_wait(robot, place, clock.now())[1]
    assert high >= 60 + 2 * 90 + 4 * 90
    assert queue.wait_if_joined(robot, clock.now())[1] >= high + 90
    asked = clock.now()
    while queue.open_ticket(robot, people["bob"]).state == TicketState.WAITING:
        assert clock.now() - asked < timedelta(hours=2)
        Turn.objects.filter(ended_at=None).update(acted_at=clock.now(), last_seen=clock.now())
        if (offer := Ticket.objects.filter(state=TicketState.OFFERED).first()) is not None:
            queue.accept(robot, offer.user, clock.now())
        left, last = queue.place_and_wait(robot, place, clock.now())[1]
        ticks(robot, [*behind, people["kim"]], clock, 10, each_s=10)
        Robot.objects.filter(cycle=Cycle.HANDOVER).update(cycle=Cycle.READY)
        assert left <= last
    waited = (clock.now() - asked).total_seconds()
    assert waited > 60 + 120 + 240
    assert low <= waited <= high


def test_a_job_waits_for_longer_turns_before_it(shuttle, people, clock):
    QueueRobot.objects.update(offers_turns=True)
    waits = []
    queue.join(shuttle, people["bob"], clock.now())
    queue.ask(shuttle, queue.Asker(guest="a" * 64, network="192.0.2.1"), "go", {"x": 1.0}, clock.now())
    for times in (1, 3):
        longer(people["bob"], times)
        (job,) = queue.forecast(shuttle, clock.now())
        assert job.ahead == 1
        waits.append(job.wait_s)
    assert [waits[1][n] - waits[0][n] for n in (0, 1)] == [2 * 75, 2 * 330]


def test_nobody_else_is_told_more_than_the_true_length(stage):
    robot, people, clock = stage
    drive(robot, people["ada"], clock.now())
    told = []
    for times in (1, 4):
        longer(people["ada"], times)
        for user in (AnonymousUser(), people["bob"]):
            told.append(snapshot(robot.slug, user, clock.now(), True))
        pages = Client(), Client()
        pages[1].force_login(people["bob"])
        for client in pages:
            for path in ("/", "/robots/mercury/", f"/turns/{Turn.objects.get().pk}/", "/status/", "/log/"):
                text = client.get(path).content.decode()
                assert "times the usual" not in text
                assert "turn_factor" not in text
    assert told[:2] == told[2:], "the running turn has its end, and says nothing of its person"
    own = Client()
    own.force_login(people["ada"])
    assert "You have 4 times the usual time" in own.get("/me/").content.decode()


def test_staff_with_the_permission_set_it_for_others_and_not_for_themselves(stage, client):
    people = stage[1]
    helper = staff("hal", "change_user", "view_user")
    client.force_login(helper)
    assert client.post(page(people["bob"]), filled(people["bob"], turn_factor=3)).status_code == 302
    assert User.objects.get(pk=people["bob"].pk).turn_factor == 3
    assert client.post(page(helper), filled(helper, turn_factor=4)).status_code == 302
    assert User.objects.get(pk=helper.pk).turn_factor == 1
    for wrong in ("0", "5", "-1", "1e9", "2.5", "x", ""):
        answer = client.post(page(people["bob"]), filled(people["bob"], turn_factor=wrong))
        assert (answer.status_code, User.objects.get(pk=people["bob"].pk).turn_factor) == (200, 3), wrong
    root = User.objects.create_superuser("root", "root@example.org", "correct horse 42")
    assert client.post(page(root), filled(root, turn_factor=2)).status_code == 403
    client.force_login(root)
    assert client.post(page(root), filled(root, turn_factor=2)).status_code == 302
    assert User.objects.get(pk=root.pk).turn_factor == 2


@pytest.mark.parametrize("codes", [(), ("view_user",), ("change_clearance", "change_robot", "change_account")])
def test_without_the_permission_nobody_sets_it(stage, client, codes):
    people = stage[1]
    client.force_login(staff("sam", *codes) if codes else people["bob"])
    for person in (people["bob"], User.objects.order_by("-pk").first()):
        answer = client.post(page(person), filled(person, turn_factor=4))
        assert answer.status_code in (302, 403)
        assert User.objects.get(pk=person.pk).turn_factor == 1


def test_no_form_of_a_person_sets_it(stage, client):
    people = stage[1]
    client.force_login(people["bob"])
    for path in ("/me/places/", "/accounts/email/", "/accounts/password/change/", "/language/", "/me/alerts/"):
        client.post(path, {"turn_factor": 4, "email": "b@example.org", "language": "de", "next": "/"})
    client.logout()
    client.post("/accounts/signup/", {
        "email": "new@example.org", "username": "newcomer", "password1": "a long enough phrase 9", "turn_factor": 4,
    })  # fmt: skip
    assert User.objects.filter(username="newcomer").exists()
    assert set(User.objects.exclude(username="ada").values_list("turn_factor", flat=True)) == {1}


def test_the_database_knows_no_other_length(stage):
    with pytest.raises(IntegrityError), transaction.atomic():
        User.objects.filter(username="bob").update(turn_factor=9)
