"""The time of day is set, in both directions, and the machine sleeps: nothing ends, and nobody gets more than before."""

import json
import os
import socket
from contextlib import suppress
from datetime import UTC, datetime, timedelta

import pytest
from django.contrib.sessions.models import Session
from django.core.cache import cache
from django.db import DataError, OperationalError
from django.db.models import F

from accounts.models import Attempt
from accounts.services import pause_left
from portal.live.sessions import RAN_OUT_S, SessionWatch, SignIn, over
from queueing import services as queue
from queueing.jobs.asking import Asker, ask
from queueing.jobs.running import _used
from queueing.jobs.suspending import resume, suspended
from queueing.models import Job, Queue, QueueRobot, Ticket, Turn, TurnSession
from queueing.steps import carry
from queueing.tasks import queue_tick
from queueing.tick import ABSENT_S, tick_seldom
from robots import probes, services
from robots.models import Command, Frame, Grant, Lease, Movie, Recording, RecordingState, Records, Robot
from robots.recordings import keeping
from robots.recordings.timeline import read_index
from robots.states import GrantEnd, GrantKind
from robots.wall_clock import FIRST, SETTLED_S, TRUSTED_S, Reading, WallClock, step_between
from tests.services.owner import made_owner
from tests.waiting import CEILING_S
from workers import tasks
from workers.housekeeping.clean import old_frames
from workers.recorder.recorder import Recorder
from workers.safety.follow import LATE_S
from workers.safety.lease import OwnerLease

pytestmark = [pytest.mark.service, pytest.mark.django_db]

HOUR, YEAR = 3600.0, 365.25 * 86_400
STEPS = {
    "an hour ahead": HOUR,
    "an hour back": -HOUR,
    "20 s back": -20.0,
    "from 1970": 56 * YEAR,
    "from 2100": -74 * YEAR,
}
SET = {name: lambda clock, by=by: clock.step(by) for name, by in STEPS.items()}
CHANGES = SET | {"the machine slept": lambda clock: clock.suspend(2 * HOUR)}
each_change = pytest.mark.parametrize("change", CHANGES.values(), ids=CHANGES)
each_step = pytest.mark.parametrize("by", STEPS.values(), ids=STEPS)


@pytest.fixture
def tick(trusted, clock):
    """A tick as the housekeeping worker does it each second."""

    def go(seconds=1.0):
        clock.go(seconds)
        trusted.follow(carry)
        queue.tick(clock.now())

    return go


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
        queue.seen(robot, people[name], clock.now(), classic=False, session=f"of {name}")


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
        Command.objects.update(created_at=clock.now())  # she is not idle
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
    queue.disconnected(driven, people["ada"], clock.now())
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


def test_rows_that_cannot_follow_stop_no_tick(driven, clock, trusted, monkeypatch):
    monkeypatch.setattr("queueing.steps._Move.everything", lambda self: (_ for _ in ()).throw(DataError("too large")))
    clock.step(HOUR)
    trusted.follow(carry)
    trusted.follow(lambda step, now: pytest.fail("again"))


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

    def meanwhile(now):
        monkeypatch.undo()
        monkeypatch.setattr("queueing.tasks.wall_clock", lambda: trusted)
        change(clock)
        queue_tick()  # by another thread of the worker
        tick_seldom(now)

    monkeypatch.setattr("queueing.tasks.tick_seldom", meanwhile)
    queue_tick()
    queue_tick()
    assert (Turn.objects.get().ended_at, left(clock)) == (None, before)
    assert Ticket.objects.get(state="waiting")


def test_a_tick_that_failed_bars_no_other_one(driven, clock, trusted, monkeypatch):
    monkeypatch.setattr("queueing.tasks.wall_clock", lambda: trusted)
    with monkeypatch.context() as broken:
        broken.setattr("queueing.tasks.tick_seldom", lambda now: (_ for _ in ()).throw(OperationalError("away")))
        with pytest.raises(OperationalError):
            queue_tick()
    clock.go(1000)
    queue_tick()
    assert Turn.objects.get().ended_at is not None


@each_change
@pytest.mark.parametrize("back", [True, False], ids=["who comes back", "who stays away"])
def test_an_absence_lasts_as_long_as_it_would_have(driven, people, clock, tick, change, back):
    queue.disconnected(driven, people["ada"], clock.now())
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


def test_what_is_counted_elsewhere_and_cannot_be_forgotten_moves_nothing_twice(driven, clock, trusted, monkeypatch):
    before = left(clock)
    monkeypatch.setattr(type(cache._connections["default"]), "clear", lambda self: (_ for _ in ()).throw(ValueError))
    clock.step(HOUR)
    trusted.follow(carry)
    trusted.follow(carry)
    assert left(clock) == before


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
        return suspended(shuttle, QueueRobot.objects.get(robot=shuttle))

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


def test_a_need_is_tried_again_after_the_time_of_day_was_set_back(robot, clock):
    from queueing.idle import open_need
    from robots.contract.capabilities import Need

    Robot.objects.update(driver="irat")
    robot.refresh_from_db()
    need = next(iter(robot.spec().all_of(Need)))
    Lease.objects.create(robot=robot, epoch=1, expires_at=clock.now())
    assert open_need(robot, need, clock.now())
    services.end_grant(services.open_grant(robot), "failed", "in vain", clock.now())
    assert not open_need(robot, need, clock.go(5))
    clock.step(-86_400)
    assert open_need(robot, need, clock.now()), "the robot would stay empty for a day"


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


def test_the_pause_after_a_failed_test_grows_by_no_more_than_a_pause(robot, people, clock):
    for _ in range(2):
        Attempt.objects.create(
            user=people["eve"], robot=robot, drawn=[], started_at=clock.now(), finished_at=clock.now(), passed=False
        )
    assert pause_left(people["eve"], robot, clock.now()) > 0
    clock.step(-86_400 * 30)
    assert pause_left(people["eve"], robot, clock.now()) == 0


# --- the robot's owner ---


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
        owner.link.seen()
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


@each_change
def test_an_owner_ends_the_turn_in_time_also_if_nobody_looks_at_the_clocks(owner, change):
    owner.follower.follow_grant()
    change(owner.clock)
    owner.clock.go(59)
    owner.follower.follow_grant()
    assert Grant.objects.get().ended_at is None
    owner.clock.go(1.5)
    assert owner.grants.over(Grant.objects.get().pk)
    owner.clock.go(LATE_S)
    owner.follower.follow_grant()
    assert Grant.objects.get().end_code == "time_up"


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
    owner.link.seen()
    owner.follower.follow_grant()
    assert not owner.grants.over(Grant.objects.get().pk)
    owner.clock.go(1.5)
    owner.follower.follow_grant()
    assert owner.grants.over(Grant.objects.get().pk)
    owner.clock.go(LATE_S)
    owner.follower.follow_grant()
    assert Grant.objects.get().end_code == "time_up"


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


def test_the_lease_of_a_process_of_this_host_that_has_ended_is_taken_as_soon_as_it_is_over(others, clock):
    waits, _ = others
    Lease.objects.update(host=socket.gethostname(), pid=2**22 + 5)
    clock.go(2.9)
    assert not waits._try()
    clock.go(0.2)
    assert waits._try()


# --- what is kept ---


@pytest.fixture
def kept(robot, clock, settings, tmp_path):
    """A recording, a picture and a movie of yesterday."""
    settings.MEDIA_ROOT = tmp_path / "media"
    settings.RECORDING = settings.RECORDING | {"MOVIE_KEEP_DAYS": 9}
    at = clock.now() - timedelta(days=1)
    grant = services.start_grant(robot, GrantKind.TURN, at, None, at)
    services.end_grant(grant, "finished", "test", at)
    recording = keeping.begin(grant, "here", at)
    path = keeping.path_of(recording)
    path.parent.mkdir(parents=True)
    path.write_bytes(b"recorded")
    keeping.finish(recording, RecordingState.READY, "", at)
    Frame.objects.create(robot=robot, taken_at=at, file="frames/x.jpg")
    Movie.objects.create(robot=robot, recording=recording, kind="mp4", asked_at=at, state="failed")
    services.note_usage(robot.pk, services.slot_of(at), sent_bytes=1)

    def there():
        shown = Recording.objects.exclude(state=RecordingState.REMOVED).count()
        return shown, Frame.objects.count(), Movie.objects.count(), path.exists()

    return there


ALL, NOTHING = (1, 1, 1, True), (0, 0, 0, False)


def cleans(there, clock, looks, monkeypatch, hours):
    """Tick and clean for some hours; return what is there then."""
    monkeypatch.setattr(tasks, "wall_clock", lambda: looks)
    for _ in range(round(hours)):
        clock.go(HOUR)
        looks.follow(carry)
        tasks.clean()
    return there()


def test_a_wrong_date_that_is_corrected_within_a_day_loses_nothing(kept, clock, trusted, monkeypatch):
    clock.step(74 * YEAR)
    assert cleans(kept, clock, trusted, monkeypatch, 23) == ALL
    clock.step(-74 * YEAR)
    assert cleans(kept, clock, trusted, monkeypatch, 20) == ALL
    clock.go(3 * YEAR)
    assert cleans(kept, clock, trusted, monkeypatch, 48) == NOTHING, "what is old goes as ever"


@pytest.mark.parametrize("by", [74 * YEAR, -56 * YEAR])
def test_a_first_start_with_a_wrong_date_loses_nothing(kept, clock, tmp_path, monkeypatch, by):
    clock.step(by)
    looks = WallClock(tmp_path / "none-yet", clock)
    assert cleans(kept, clock, looks, monkeypatch, 23) == ALL
    clock.step(-by)
    assert cleans(kept, clock, looks, monkeypatch, 20) == ALL


def test_what_was_stored_while_it_was_1970_is_kept(kept, clock, trusted, monkeypatch):
    old = datetime(1970, 1, 2, tzinfo=UTC)
    for rows, name in ((Frame, "taken_at"), (Recording, "began_at"), (Movie, "asked_at")):
        rows.objects.update(**{name: old})
    assert cleans(kept, clock, trusted, monkeypatch, 20) == ALL
    assert old_frames(clock.now()) == 0


def test_no_file_is_taken_for_old_because_the_time_of_day_was_set_ahead(kept, clock, trusted, settings, monkeypatch):
    """As one that is being written at this moment."""
    new = settings.MEDIA_ROOT / keeping.FOLDER / "mercury" / "20260101" / "120000-abc.new"
    new.parent.mkdir(parents=True, exist_ok=True)
    new.write_bytes(b"part")
    os.utime(new, (clock.now().timestamp(),) * 2)
    clock.step(5 * HOUR)
    trusted.follow(carry)
    monkeypatch.setattr(tasks, "wall_clock", lambda: trusted)
    tasks.clean()
    assert new.exists()
    clock.go(SETTLED_S)
    trusted.follow(carry)
    tasks.clean()
    assert not new.exists()


def test_a_picture_is_taken_out_of_a_recording_during_which_the_time_of_day_was_set_back(kept, robot, clock):
    recording = Recording.objects.get()
    Recording.objects.update(ended_at=recording.began_at - timedelta(hours=1))
    found = keeping._around(robot, recording.began_at - timedelta(minutes=70))
    assert [one.pk for one in found] == [recording.pk]


class Recorded:
    """A turn that is recorded to a file, with an event each second; what a page is told of it."""

    def __init__(self, robot, clock):
        self.clock, self.expected_ms = clock, [0]
        self.recorder = Recorder(clock, "here")
        Robot.objects.update(records=Records.WORK)
        self.grant = services.start_grant(robot, GrantKind.TURN, clock.now(), None, clock.now() + timedelta(minutes=5))
        self.recorder._look()
        self.recorder._tell_all("notice", "began")

    def goes_on(self, seconds=3):
        for _ in range(seconds):
            self.clock.go(1)
            self.recorder._tell_all("notice", "goes on")
            self.expected_ms.append(self.expected_ms[-1] + 1000)

    def starts_again(self, seconds=4):
        """Let the recorder stop, and the next one go on with the file."""
        self.recorder._end_all()
        self.clock.go(seconds)
        self.recorder = Recorder(self.clock, "here")
        self.recorder._look()

    def ended(self):
        services.end_grant(self.grant, GrantEnd.FINISHED, "over", self.clock.now())
        self.recorder._look()
        (one,) = self.recorder._ending
        assert one.taping.written.wait(CEILING_S)
        self.recorder._look()
        row = Recording.objects.get()
        return row, read_index(keeping.path_of(row))


@pytest.fixture
def recorded(robot, owned, clock, trusted, settings, tmp_path, monkeypatch):
    settings.MEDIA_ROOT = tmp_path / "media"
    settings.RECORDING = settings.RECORDING | {"FREE_MB": 0}
    monkeypatch.setattr(Recorder, "_measure_offset", lambda self: None)  # the clock of this test is the database's
    return Recorded(robot, clock)


@each_step
def test_a_recording_goes_on_evenly(recorded, clock, trusted, by):
    began_ms = clock.now().timestamp() * 1000
    recorded.goes_on()
    clock.step(by)
    recorded.goes_on(1)
    trusted.follow(carry)
    recorded.goes_on()
    row, index = recorded.ended()
    assert (row.state, row.reason) == ("ready", "")
    assert [event["after_ms"] for event in index.events] == recorded.expected_ms
    assert index.began_ms == pytest.approx(began_ms, abs=2)
    assert len(index.needs) == 2, "slices of 5 s that a page asks for"


@each_step
def test_a_recording_goes_on_when_its_recorder_is_started_again_after_the_time_of_day_was_set(recorded, clock, by):
    recorded.goes_on()
    clock.step(by)
    recorded.starts_again()
    recorded.goes_on()
    row, index = recorded.ended()
    assert row.state == "ready"
    after_ms = [event["after_ms"] for event in index.events]
    assert after_ms == sorted(after_ms)
    assert len(after_ms) == len(recorded.expected_ms) + 1, "with a word of the gap"
    assert after_ms[-1] <= recorded.expected_ms[-1] + 5000
    assert len(index.needs) <= 3


def test_a_recording_whose_recorder_is_started_again_keeps_its_time(recorded, clock):
    recorded.goes_on()
    recorded.starts_again()
    recorded.goes_on()
    assert recorded.ended()[1].events[-1]["after_ms"] == 10_000


# --- what notices it ---


def test_it_is_noticed_while_the_worker_that_looks_was_started_again(clock, tmp_path):
    seen = []
    for change in (lambda: None, lambda: clock.step(HOUR), lambda: clock.suspend(HOUR), lambda: None):
        change()
        clock.go(5)
        WallClock(tmp_path / "clock", clock).follow(lambda step, now: seen.append((step.moved, step.paused)))
    hour, none = timedelta(hours=1), timedelta()
    assert seen == [(hour, none), (none, hour)]


@pytest.mark.parametrize(("by", "moved", "paused"), [(HOUR, 0, HOUR), (-HOUR, -HOUR, 0), (-74 * YEAR, -74 * YEAR, 0)])
def test_the_time_that_a_machine_was_off_counts_for_nobody(by, moved, paused):
    before = Reading("one boot", 1e9, 5000.0, 4000.0)
    step = step_between(before, Reading("the next", 1e9 + by, 10.0, 10.0))
    assert (step.moved.total_seconds(), step.paused.total_seconds()) == (moved, paused)


@pytest.mark.parametrize(
    "data",
    [b"", b"{", b"null", b"[]", b'{"seen": {}, "doubted_s": 0}', b"\xff" * 100,
     *(json.dumps({"seen": {"boot": "b", "wall": wall, "lasted": 1, "awake": at}, "doubted_s": doubt}).encode()
       for wall, at, doubt in ((1e308, 1, 0), (float("nan"), 1, 0), (float("inf"), 1, 0), ("1", 1, 0), (None, 1, 0),
                               (1e9, 1e308, 0), (1e9, float("nan"), 0), (1e9, 1, float("nan")), (1e9, 1, 1e308)))],
)  # fmt: skip
def test_a_file_with_rubbish_is_as_none(clock, tmp_path, data):
    (tmp_path / "clock").write_bytes(data)
    looks = WallClock(tmp_path / "clock", clock)
    looks.follow(lambda step, now: pytest.fail("nothing was seen before"))
    assert looks.age_now == FIRST
    clock.go(TRUSTED_S)
    looks.follow(lambda step, now: pytest.fail("no step"))
    assert looks.age_now == clock.now()


def test_a_step_that_could_not_be_kept_is_not_carried_again_by_the_next_start(clock, tmp_path, monkeypatch):
    file = tmp_path / "clock"
    looks, seen = WallClock(file, clock), []
    looks.follow(lambda step, now: pytest.fail("nothing was seen before"))
    (tmp_path / "clock.part").mkdir()  # it cannot be written
    clock.step(HOUR)
    for begin in (lambda: looks, lambda: WallClock(file, clock)):
        clock.go(1)
        begin().follow(lambda step, now: seen.append(step.moved.total_seconds()))
    assert seen == [HOUR]


def test_a_disk_that_is_full_stops_no_look(clock, tmp_path):
    (tmp_path / "file").write_bytes(b"")
    looks = WallClock(tmp_path / "file" / "clock", clock)
    seen = []
    for _ in range(2):
        clock.step(HOUR)
        looks.follow(lambda step, now: seen.append(step))
    assert len(seen) == 1


def test_the_clocks_of_this_machine_agree(tmp_path):
    looks = WallClock(tmp_path / "clock")
    for _ in range(3):
        looks.follow(lambda step, now: pytest.fail(str(step)))
