"""What a robot does between jobs: its own needs, idle behaviour, and rest while nobody watches."""

import pytest

from queueing import services as queue
from queueing.models import QueueRobot
from queueing.services import ask
from robots import bus, services
from robots.models import Command, Grant, Lease, Robot
from robots.states import CommandState, Cycle, GrantEnd, GrantKind
from tests.services.test_jobs import GUEST, running, settle
from workers.commands import rows

pytestmark = [pytest.mark.service, pytest.mark.django_db]


def battery(clock, value):
    Lease.objects.update(state={"values": {"battery": value}}, state_at=clock.now())


def test_a_need_comes_before_everybody_and_what_it_cuts_short_waits_again(shuttle, people, clock):
    job = ask(shuttle, GUEST, "go", {"x": 1.0}, clock.now())
    queue.tick(clock.now())
    battery(clock, 0.2)
    queue.tick(clock.go(1))
    grant = services.open_grant(shuttle)
    assert (grant.kind, grant.holder, grant.commands.get().kind) == ("upkeep", None, "dock")
    cut, dock = Command.objects.select_related("robot", "grant").order_by("id")
    rows.finish(cut, CommandState.CANCELLED, clock.go(1), "The robot's time for this is over.")
    queue.tick(clock.now())
    job.refresh_from_db()
    assert (job.state, job.start_tag, job.faults) == ("waiting", 0.0, 0)
    assert job.reason == (
        "Interrupted, because the robot's own need comes first: dock. "
        "It keeps its place, has cost nothing so far, and goes on as soon as the robot can."
    )
    battery(clock, 0.5)
    rows.finish(dock, CommandState.COMPLETED, clock.go(1))
    queue.tick(clock.now())
    assert services.open_grant(shuttle).kind == "upkeep", "not full yet"
    battery(clock, 0.95)
    settle(clock)
    assert running() == job
    assert Robot.objects.get().cycle == Cycle.READY


def test_a_need_that_failed_is_tried_again_after_its_pause_whatever_picture_staff_take_meanwhile(
    shuttle, people, clock
):
    battery(clock, 0.2)
    queue.tick(clock.now())
    settle(clock, CommandState.FAILED, "The dock was not found.")
    picture = services.start_grant(shuttle, GrantKind.UPKEEP, clock.go(1), people["kim"])
    services.end_grant(picture, GrantEnd.FINISHED, "done", clock.now())
    battery(clock, 0.2)
    queue.tick(clock.go(10))
    assert services.open_grant(shuttle) is None
    battery(clock, 0.2)
    queue.tick(clock.go(30))
    assert services.open_grant(shuttle).kind == "upkeep"


def test_a_need_that_ends_idle_behaviour_is_named_as_the_reason(shuttle, clock):
    QueueRobot.objects.update(watched_at=clock.now())
    queue.tick(clock.now())
    battery(clock, 0.2)
    queue.tick(clock.go(1))
    grant = Grant.objects.get(kind=GrantKind.IDLE)
    assert (grant.end_code, grant.end_reason) == (GrantEnd.PREEMPTED, "the robot's own need comes first: dock")


def test_idle_behaviour_runs_in_slices_gives_way_and_rests_when_nobody_watches(shuttle, people, clock):
    QueueRobot.objects.update(watched_at=clock.now())
    queue.tick(clock.now())
    grant = services.open_grant(shuttle)
    assert (grant.kind, grant.commands.get().kind, (grant.until - clock.now()).total_seconds()) == ("idle", "roam", 60)
    job = ask(shuttle, GUEST, "go", {"x": 1.0}, clock.go(1))
    queue.tick(clock.now())
    grant.refresh_from_db()
    assert (grant.end_code, running()) == (GrantEnd.PREEMPTED, job)
    for command in Command.objects.select_related("robot", "grant").order_by("id"):
        rows.finish(command, CommandState.COMPLETED, clock.now())
    queue.tick(clock.go(30))
    assert services.open_grant(shuttle).kind == "idle", "somebody asked a moment ago"
    queue.tick(clock.go(61))
    queue.tick(clock.go(60))
    assert services.open_grant(shuttle) is None, "nobody has watched for a minute"


def test_idle_behaviour_goes_on_while_no_web_process_is_heard(shuttle, clock, monkeypatch):
    monkeypatch.setattr("robots.bus.may_be_watched", lambda slug: True)  # as it says then, see the next test
    for slices in range(1, 5):
        queue.tick(clock.now())
        assert Grant.objects.filter(kind=GrantKind.IDLE).count() == slices
        settle(clock, seconds=59)
        clock.go(1)
    assert services.open_grant(shuttle).kind == "idle"


@pytest.mark.timed
def test_a_silent_web_tier_is_not_nobody(redis_server):
    bus.connection().flushall()
    assert bus.may_be_watched("mercury"), "no page server is heard"
    bus.connection().set(bus.web_key(), 1)
    assert not bus.may_be_watched("mercury")
    bus.watch("mercury", "state")
    assert bus.may_be_watched("mercury")


def slices_in(clock, seconds, ends, every=1):
    """Advance the queue each `every` s; `ends(command)` ends what idle behaviour begins. Return how many it began."""
    before = Grant.objects.filter(kind=GrantKind.IDLE).count()
    for _ in range(seconds // every):
        QueueRobot.objects.update(watched_at=clock.now())
        queue.tick(clock.go(every))
        for command in Command.objects.select_related("robot", "grant").filter(ended_at=None):
            ends(command)
    return Grant.objects.filter(kind=GrantKind.IDLE).count() - before


@pytest.mark.parametrize("state", ["rejected", "failed", "expired", "cancelled", "completed", "unknown"])
def test_idle_behaviour_that_ends_at_once_however_is_tried_twice_a_minute_and_no_oftener(shuttle, clock, state):
    assert slices_in(clock, 60, lambda c: rows.finish(c, CommandState(state), clock.now(), "No way.")) == 2


def test_idle_behaviour_that_the_robot_does_not_have_is_offered_to_it_once_an_hour(shuttle, people, clock):
    def refuse(command):
        rows.finish(command, CommandState.REJECTED, clock.now(), "By hand only.", {"code": "bad_request"})

    assert slices_in(clock, 60, refuse) == 1
    assert slices_in(clock, 3600, refuse, every=10) == 1
    assert Command.objects.count() == 2
    job = ask(shuttle, GUEST, "go", {"x": 1.0}, clock.now())
    queue.tick(clock.now())
    assert running() == job, "people are served meanwhile"


def test_after_whoever_came_first_idle_behaviour_goes_on_at_once(shuttle, people, clock):
    QueueRobot.objects.update(watched_at=clock.now())
    queue.tick(clock.now())
    ask(shuttle, GUEST, "go", {"x": 1.0}, clock.go(1))
    queue.tick(clock.now())
    for command in Command.objects.select_related("robot", "grant").order_by("id"):
        rows.finish(command, CommandState.COMPLETED, clock.now())
    queue.tick(clock.go(1))
    assert services.open_grant(shuttle).kind == "idle"
