"""A waiting job that the robot's state has made impossible, as a goal on a deleted map, ends at once, uncharged."""

from datetime import timedelta

import pytest
from django.test import Client

from portal.web.statistics import reading
from queueing import services as queue
from queueing.models import Account, Job
from queueing.services import Asker, ask, unseen_jobs
from robots.kit.contract.capabilities import GoodWhile, Statistics
from robots.kit.contract.find import spec_of
from robots.models import Command, Lease, Robot
from robots.states import Cycle
from tests.services.test_jobs import GUEST, OTHER, settle

pytestmark = [pytest.mark.service, pytest.mark.django_db]
GONE = "The rail was taken away, so this place is no longer there."


@pytest.fixture
def busy(shuttle):
    """The robot charges, so nothing is promoted."""
    Robot.objects.update(cycle=Cycle.HANDOVER)
    return shuttle


def tells(clock, ago_s=0.0, **values):
    """The owner stored these values of channels."""
    Lease.objects.update(state={"values": values}, state_at=clock.now() - timedelta(seconds=ago_s))


def go(robot, asker, clock, **more):
    return ask(robot, asker, "go", {"x": 1.0, **more}, clock.now())


def ended(*jobs):
    for job in jobs:
        job.refresh_from_db()
    return [(job.state, job.reason, job.code, job.charged) for job in jobs]


WAITS, DROPPED = ("waiting", "", "", None), ("failed", GONE, "rail", 0.0)


def test_jobs_of_a_rail_that_was_taken_away_end_while_it_charges_and_cost_nothing(busy, people, clock):
    ada = Asker(user=people["ada"])
    old, without, new = go(busy, ada, clock, rail=1), go(busy, GUEST, clock), go(busy, OTHER, clock, rail=2)
    tells(clock, rail=1.0)
    queue.tick(clock.go(10))
    assert ended(old, without, new) == [WAITS] * 3, "that state is older than the last of them"
    tells(clock, rail=2.0)
    queue.tick(clock.go(1))
    assert ended(old, without, new) == [DROPPED, WAITS, WAITS]
    assert Account.objects.get(user=people["ada"]).finish_tag == 0.0
    assert [job.pk for job in unseen_jobs(ada, clock.now())] == [old.pk], "its asker is told"
    assert Command.objects.count() == 0


@pytest.mark.parametrize(
    "state",
    [{}, {"values": {"battery": 1.0}}, {"values": {"rail": None}}, {"values": {"rail": "2"}}, {"values": None}],
)
def test_what_the_robot_does_not_tell_ends_nothing(busy, clock, state):
    job = go(busy, GUEST, clock, rail=1)
    Lease.objects.update(state=state, state_at=clock.go(10))
    queue.tick(clock.now())
    assert ended(job) == [WAITS]


def test_neither_an_old_state_nor_one_from_before_the_job_ends_it(busy, clock):
    tells(clock, rail=1.0)
    job = go(busy, GUEST, clock, rail=2)  # of the rail that its asker saw a moment ago
    queue.tick(clock.go(1))
    assert ended(job) == [WAITS]
    tells(clock, ago_s=-120, rail=3.0)
    queue.tick(clock.go(200))
    assert ended(job) == [WAITS], "the owner is silent"
    tells(clock, rail=2.0)
    queue.tick(clock.now())
    assert ended(job) == [WAITS], "it is still good"


def test_a_job_that_a_need_cut_short_ends_too_and_the_next_of_its_asker_waits_on(shuttle, people, clock):
    ada = Asker(user=people["ada"])
    first, second = go(shuttle, ada, clock, rail=1), go(shuttle, ada, clock, rail=2)
    queue.tick(clock.now())
    Robot.objects.update(cycle=Cycle.HANDOVER)
    settle(clock, "failed", "The motor is hot.")
    tells(clock, rail=2.0)
    Lease.objects.update(state_at=clock.go(5))
    queue.tick(clock.now())
    assert ended(first) == [DROPPED]
    second.refresh_from_db()
    assert (second.state, second.start_tag) == ("waiting", 0.0)


def test_a_running_job_is_its_drivers_matter(shuttle, clock):
    job = go(shuttle, GUEST, clock, rail=1)
    queue.tick(clock.now())
    tells(clock, rail=2.0)
    Lease.objects.update(state_at=clock.go(5))
    queue.tick(clock.now())
    job.refresh_from_db()
    assert job.state == "running"


def test_it_is_counted_in_the_row_that_the_spec_names_and_was_never_attempted(busy, clock, monkeypatch):
    monkeypatch.setattr("portal.web.statistics.views.SYSTEM", clock)
    for asker in (GUEST, OTHER):
        go(busy, asker, clock, rail=1)
    tells(clock, ago_s=-5, rail=2.0)
    queue.tick(clock.go(5))
    rows = {r["label"]: r["value"] for r in Client().get("/robots/mercury/statistics.json").json()["rows"]}
    assert rows["Dropped, because the rail was taken away"] == 2
    assert rows["Trips attempted"] == rows["Refused by the robot"] == rows["Given up by the robot"] == 0
    monkeypatch.setattr(Statistics, "ends", ())
    told = Job.objects.first()
    assert reading.outcome_of(told.state, 0, "rejected", told.code, frozenset()) == reading.REFUSED


def test_the_tick_asks_only_while_such_jobs_wait(busy, clock, django_assert_num_queries):
    from queueing.jobs.judging import judge_waiting

    mine = queue.queue_of(busy)
    with django_assert_num_queries(1):
        judge_waiting(mine, clock.now())


def test_a_goal_of_the_irat_is_good_while_its_map_is_the_robots():
    spec = spec_of("irat")
    found = spec.capability(GoodWhile)
    assert (found.kind, found.argument, found.channel, found.code) == ("goal", "map", "map", "map_cleared")
    assert found.code in [code for code, _ in spec.capability(Statistics).ends]
    assert any(argument.name == "map" and argument.required for argument in spec.command("goal").arguments)


def test_goals_on_a_map_that_the_irat_cleared_end_while_it_charges(busy, people, clock):
    Robot.objects.update(driver="irat")
    robot = Robot.objects.get()
    goal = {"x": 0.5, "y": 0.5, "experience": 3}
    old, new = (
        ask(robot, asker, "goal", {**goal, "map": number}, clock.now()) for asker, number in ((GUEST, 4), (OTHER, 5))
    )
    tells(clock, ago_s=-5, map=5)
    queue.tick(clock.go(5))
    why = "The map was cleared, so this place is no longer known."
    assert ended(old, new) == [("failed", why, "map_cleared", 0.0), WAITS]
