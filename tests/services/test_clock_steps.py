"""The time of day is set, in both directions, and the machine sleeps: nothing ends, and nobody gets more than before."""

from contextlib import suppress
from datetime import timedelta

import pytest
from django.contrib.sessions.models import Session
from django.core.cache import cache
from django.db import DataError, OperationalError

from accounts.models import Attempt
from accounts.services import pause_left
from portal.live.sessions import RAN_OUT_S, SessionWatch, SignIn, over
from queueing import services as queue
from queueing.jobs.running import _used
from queueing.models import Job, Queue, QueueRobot, Ticket, Turn, TurnSession
from queueing.rows import is_suspended
from queueing.services import Asker, ask, resume
from queueing.steps import carry
from queueing.tasks import queue_tick
from queueing.tick import ABSENT_S, tick_seldom
from robots import services
from robots.models import Command, Grant, Lease, Robot
from robots.services import probes
from tests.services.clock_steps import HOUR, YEAR, drive, each_change, each_step

pytestmark = pytest.mark.django_db


@pytest.fixture
def tick(trusted, clock):
    """A tick as the housekeeping worker does it each second."""
    return lambda seconds=1.0: (clock.go(seconds), trusted.follow(carry), queue.tick(clock.now()))


@pytest.fixture
def driven(robot, people, owned, clock, tick):
    """Ada drives and has just done something; bob waits."""
    for name in ("ada", "bob"):
        queue.join(robot, people[name], clock.now())
        tick()
    queue.accept(robot, people["ada"], clock.now())
    tick(100)
    present(robot, people, clock)
    grant = services.open_grant(robot)
    Command.objects.create(
        robot=robot, grant=grant, kind="ready", client_seq=1, epoch=5, state="completed", issued_by=people["ada"],
        created_at=clock.now(), deadline=clock.now() + timedelta(seconds=5), ended_at=clock.now(),
    )  # fmt: skip
    tick()
    return robot


def present(robot, people, clock):
    for name in ("ada", "bob"):
        queue.note_presence(robot, people[name], clock.now(), classic=False, session=f"of {name}")


def left(clock):
    return (Turn.objects.get().until - clock.now()).total_seconds()


@each_change
def test_a_turn_and_a_place_go_on_and_last_as_long_as_they_would_have(driven, people, clock, tick, change):
    before = left(clock)
    assert before > 100
    change(clock)
    tick()
    turn = Turn.objects.get()
    assert (turn.ended_at, left(clock)) == (None, pytest.approx(before - 1, abs=0.01))
    assert turn.grant.until == turn.until
    assert Ticket.objects.get(user=people["bob"]).state == "waiting"
    tick(6)  # nobody has reported since
    assert Turn.objects.get().ended_at is None
    for _ in range(int(left(clock)) // 20 + 2):
        present(driven, people, clock)
        if left(clock) > 0:
            assert Turn.objects.get().ended_at is None
        Command.objects.update(created_at=clock.now(), ended_at=clock.now())  # she is not idle
        tick(20)
    turn = Turn.objects.get()
    assert turn.end_reason == "time is up"
    assert (turn.ended_at - turn.until).total_seconds() <= 20
    assert 0 < turn.charged_s <= 600


@each_change
def test_who_did_something_is_not_idle_and_who_reported_is_not_away(driven, people, clock, tick, change):
    for seconds in (1, 1, 1):
        change(clock)
        tick(seconds)
    assert Turn.objects.get().ended_at is None
    TurnSession.objects.get(last_seen__gte=clock.now() - timedelta(seconds=10))
    tick(25)  # now nobody has reported for 29 s
    queue.note_disconnection(driven, people["ada"], clock.now())
    tick(settings_s("RECONNECT_S") + 1)
    assert Turn.objects.get().end_reason == "connection lost", "an absence counts as ever"


def settings_s(name):
    from django.conf import settings

    return settings.FARHAND[name]


@each_change
def test_an_offer_lasts_as_long_as_it_would_have(robot, people, owned, clock, tick, change):
    queue.join(robot, people["ada"], clock.now())
    tick()
    ticket = Ticket.objects.get()
    assert ticket.state == "offered"
    before = ticket.offer_until - clock.now()
    change(clock)
    tick(0)
    ticket.refresh_from_db()
    assert (ticket.state, ticket.offer_until - clock.now()) == ("offered", before)
    tick(before.total_seconds() + 1)
    ticket.refresh_from_db()
    assert ticket.state == "expired"


@each_step
def test_who_reports_between_the_step_and_the_look_stays_present(driven, people, clock, tick, by):
    clock.go(0.5)
    clock.step(by)
    present(driven, people, clock)
    now = clock.now()
    tick(0.2)
    assert set(Ticket.objects.values_list("last_seen", flat=True)) == {now}
    assert Turn.objects.get().last_seen == now
    assert Turn.objects.get().ended_at is None


@each_step
def test_a_turn_that_begins_between_the_step_and_the_look_has_its_length(robot, people, owned, clock, tick, by):
    queue.join(robot, people["ada"], clock.now())
    tick()
    clock.step(by)
    clock.go(0.3)
    Lease.objects.update(expires_at=clock.now() + timedelta(seconds=2))  # its owner has renewed it since
    Ticket.objects.update(offer_until=clock.now() + timedelta(seconds=9))  # else it can be refused for this moment
    queue.accept(robot, people["ada"], clock.now())
    length = Turn.objects.get().until - clock.now()
    tick(0)
    assert Turn.objects.get().until - clock.now() == length
    assert services.open_grant(robot).until - clock.now() == length


@pytest.mark.service
def test_the_machine_of_the_look_alone_slept_and_others_turns_go_on(robot, people, owned, clock, tick):
    tick()
    clock.suspend(10 * HOUR - 60)
    turn = drive(robot, people, clock)
    clock.suspend(60)
    tick(1)
    after = Turn.objects.get()
    assert after.until - turn.until <= timedelta(seconds=61)
    assert after.last_seen <= clock.now(), "nothing is written ahead"
    assert after.ended_at is None


@pytest.mark.service
def test_a_database_that_is_away_is_asked_again_and_the_step_is_carried_once(driven, clock, trusted):
    before = left(clock)
    clock.step(HOUR)

    def away(step, now):
        raise OperationalError("away")

    with suppress(OperationalError):
        trusted.follow(away)
    assert left(clock) == before - HOUR
    trusted.follow(carry)
    assert left(clock) == before
    trusted.follow(carry)
    assert left(clock) == before


@pytest.mark.service
def test_rows_that_cannot_follow_stop_no_tick(driven, clock, trusted, monkeypatch):
    monkeypatch.setattr("queueing.steps._Move.everything", lambda self: (_ for _ in ()).throw(DataError("too large")))
    clock.step(HOUR)
    trusted.follow(carry)
    trusted.follow(lambda step, now: pytest.fail("again"))


@pytest.mark.service
def test_the_task_looks_at_the_clock_before_it_ends_anything(driven, clock, trusted, monkeypatch):
    monkeypatch.setattr("queueing.tasks.wall_clock", lambda: trusted)
    clock.step(HOUR)
    clock.go(1)
    queue_tick()
    assert Turn.objects.get().ended_at is None


@each_change
def test_a_tick_that_has_begun_judges_nothing_that_has_followed_the_clock_since(
    driven, clock, trusted, monkeypatch, change
):
    """It goes on by the time at which it looked; until it is over no other one looks."""
    monkeypatch.setattr("queueing.tasks.wall_clock", lambda: trusted)
    before = left(clock)

    def meanwhile(now, up_since):
        monkeypatch.undo()
        monkeypatch.setattr("queueing.tasks.wall_clock", lambda: trusted)
        change(clock)
        clock.spawn(queue_tick, "another thread of the worker").join()
        tick_seldom(now)

    monkeypatch.setattr("queueing.tasks.tick_seldom", meanwhile)
    queue_tick()
    queue_tick()
    assert (Turn.objects.get().ended_at, left(clock)) == (None, before)
    assert Ticket.objects.get(state="waiting")


@pytest.mark.service
def test_a_tick_that_failed_bars_no_other_one(driven, clock, trusted, monkeypatch):
    monkeypatch.setattr("queueing.tasks.wall_clock", lambda: trusted)
    with monkeypatch.context() as broken:
        broken.setattr("queueing.tasks.tick_seldom", lambda *_: (_ for _ in ()).throw(OperationalError("away")))
        with pytest.raises(OperationalError):
            queue_tick()
    clock.go(1000)
    queue_tick()
    assert Turn.objects.get().ended_at is not None


@each_change
@pytest.mark.parametrize("back", [True, False], ids=["who comes back", "who stays away"])
def test_an_absence_lasts_as_long_as_it_would_have(driven, people, clock, tick, change, back):
    queue.note_disconnection(driven, people["ada"], clock.now())
    tick(10)
    change(clock)
    tick(1)
    tick(8)
    assert Turn.objects.get().ended_at is None, "19 s of 20"
    if back:
        present(driven, people, clock)
    tick(3)
    assert Turn.objects.get().end_reason == ("" if back else "connection lost")


@each_change
def test_the_place_of_who_reports_no_more_is_kept_as_long_as_it_would_have_been(robot, people, clock, tick, change):
    queue.join(robot, people["bob"], clock.now())
    Queue.objects.update(paused=True)
    tick(ABSENT_S - 30)
    change(clock)
    tick(1)
    tick(28)
    assert Ticket.objects.get().state == "waiting"
    tick(2)
    assert Ticket.objects.get().end_reason == "was away too long"


@pytest.mark.service
def test_what_is_counted_elsewhere_and_cannot_be_forgotten_moves_nothing_twice(driven, clock, trusted, monkeypatch):
    before = left(clock)
    monkeypatch.setattr(type(cache._connections["default"]), "clear", lambda self: (_ for _ in ()).throw(ValueError))
    clock.step(HOUR)
    trusted.follow(carry)
    trusted.follow(carry)
    assert left(clock) == before


@pytest.mark.service
@pytest.mark.parametrize("by", [30 * 86_400.0, -30 * 86_400.0, 56 * YEAR])
def test_a_sign_in_outlives_a_step_and_no_sleep_lengthens_it(driven, clock, tick, by):
    day = timedelta(days=1)
    Session.objects.create(session_key="a", session_data="", expire_date=clock.now() + day)
    clock.step(by)
    tick(0)
    assert Session.objects.get().expire_date - clock.now() == day
    clock.suspend(HOUR)
    tick(0)
    assert Session.objects.get().expire_date - clock.now() == day - timedelta(hours=1)


class Socket:
    def __init__(self, sign_in):
        self.sign_in = sign_in

    def judge(self, user):
        return None


@each_step
def test_a_socket_waits_until_its_sign_in_has_followed_the_time_of_day(people, clock, tick, by):
    watch = SessionWatch(clock.monotonic)
    sockets = []
    for name in ("ada", "bob", "eve"):
        Session.objects.create(session_key=name, session_data="", expire_date=clock.now() + timedelta(days=9))
        sockets.append(Socket(SignIn(name, people[name].pk, people[name].get_session_auth_hash())))

    def ended():
        return [s.sign_in.key for s, _ in watch._lasting(over([(s, s.sign_in) for s in sockets], clock.now()))]

    tick()
    assert not ended()
    clock.step(by)
    assert not ended()
    clock.go(1)
    assert not ended()
    tick(0)
    assert not ended()
    Session.objects.filter(session_key="bob").update(expire_date=clock.now())
    Session.objects.filter(session_key="eve").delete()
    assert ended() == ["eve"], "who has signed out leaves at once"
    clock.go(RAN_OUT_S)
    assert ended() == ["bob", "eve"]


@pytest.mark.service
def test_what_was_counted_against_somebody_is_forgotten(driven, clock, tick):
    cache.set("attempts", [clock.now().timestamp()], 300)
    tick(1)
    assert cache.get("attempts")
    clock.step(-86_400)
    tick(1)
    assert cache.get("attempts") is None


@each_step
def test_a_job_that_waits_goes_on_waiting_and_costs_no_more(shuttle, clock, tick, by):
    job = ask(shuttle, Asker(guest="a" * 64, network="192.0.2.1"), "go", {"x": 1.0}, clock.now())
    tick()
    assert Job.objects.get().state == "running"
    QueueRobot.objects.update(charged_in="seconds")
    grant = services.open_grant(shuttle)
    length = grant.until - grant.opened_at
    Grant.objects.update(ended_at=clock.step(by))  # by its owner, before anybody looked
    grant.refresh_from_db()
    assert 0 <= _used(grant, shuttle) <= length.total_seconds()
    assert Job.objects.get(pk=job.pk).state == "running"


@each_step
def test_a_stop_suspends_until_staff_resume_whatever_the_time_of_day_was(shuttle, people, clock, tick, by):
    def stopped():
        shuttle.refresh_from_db()
        return is_suspended(shuttle, QueueRobot.objects.get(robot=shuttle))

    Robot.objects.update(stopped_at=clock.now())
    assert stopped()
    clock.step(by)
    resume(shuttle, people["kim"], clock.now())
    tick()
    assert not stopped()
    Robot.objects.update(stopped_at=clock.go(5))
    assert stopped(), "the next stop counts"
    tick()
    assert stopped()


@pytest.mark.service
def test_a_need_is_tried_again_after_the_time_of_day_was_set_back(robot, clock):
    from queueing.idle import open_need
    from robots.kit.contract.capabilities import Need

    Robot.objects.update(driver="irat")
    robot.refresh_from_db()
    need = next(iter(robot.spec().all_of(Need)))
    Lease.objects.create(robot=robot, epoch=1, expires_at=clock.now())
    assert open_need(robot, need, clock.now())
    services.end_grant(services.open_grant(robot), "failed", "in vain", clock.now())
    assert not open_need(robot, need, clock.go(5))
    clock.step(-86_400)
    assert open_need(robot, need, clock.now()), "the robot would stay empty for a day"


@pytest.mark.service
def test_a_test_of_a_connection_that_nobody_ends_bars_others_for_as_long_as_ever(
    robot, people, clock, tick, monkeypatch
):
    monkeypatch.setattr("robots.bus.wake_probes", lambda: True)
    probes.ask(robot, people["kim"], clock.now())
    assert probes.claim(clock.now()) is not None
    with pytest.raises(probes.NotPermitted):
        probes.ask(robot, people["kim"], clock.go(5))
    clock.step(-HOUR)
    tick()
    with pytest.raises(probes.NotPermitted):
        probes.ask(robot, people["kim"], clock.now())
    probes.ask(robot, people["kim"], clock.go(probes.LIMIT_S))


@pytest.mark.service
def test_the_pause_after_a_failed_test_grows_by_no_more_than_a_pause(robot, people, clock):
    for _ in range(2):
        Attempt.objects.create(
            user=people["eve"], robot=robot, drawn=[], started_at=clock.now(), finished_at=clock.now(), passed=False
        )
    assert pause_left(people["eve"], robot, clock.now()) > 0
    clock.step(-86_400 * 30)
    assert pause_left(people["eve"], robot, clock.now()) == 0
