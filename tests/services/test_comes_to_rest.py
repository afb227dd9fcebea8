"""After a grant whose motion may go on without a command, a further grant brings the robot to rest."""

from datetime import timedelta

import pytest
from django.contrib.admin.models import LogEntry

from queueing import services as queue
from queueing.models import QueueRobot
from queueing.offers import why_not_ready
from queueing.services import ask, cancel
from robots import services
from robots.kit.clock import SYSTEM
from robots.kit.contract.errors import NotPermitted
from robots.models import Command, Grant, Lease, Robot
from robots.services.commands import put
from robots.services.configuring import configure
from robots.services.status import status_of
from robots.states import CommandState, Cycle, GrantEnd, GrantKind
from tests.packaged import installed_from, of_spec
from tests.services.browsers import signed_in
from tests.services.test_jobs import GUEST, OTHER
from workers.commands import rows

pytestmark = [pytest.mark.service, pytest.mark.django_db]
REST_S, ALONE_S, MOST_S = 2.0, 20.0, 60.0
SPEC = f"""
from robots.kit.contract.capabilities import Setting
from robots.kit.contract.policies import Bound, Policies
from robots.kit.contract.spec import ANYONE, Argument, CommandKind, Spec
def spec():
    alone, asked = Policies(on_link_lost=Bound({ALONE_S}, setting="alone_s")), frozenset({{ANYONE}})
    return Spec("Rover", (
        CommandKind("patrol", "Patrol", asked_by=asked, policies=alone, limit_s=60.0),
        CommandKind("go", "Go", asked_by=asked),
        CommandKind("tone", "Tone", (Argument("pitch", "Hz", 20.0, 2e4),), lane="config", moves=False,
                    default={{"pitch": 440.0}}),
    ), rest_s={REST_S}, capabilities=(Setting("alone_s", "Alone", unit="s", low=0.0, high={MOST_S}, default={ALONE_S}),))
"""


@pytest.fixture
def rover(robot, people, clock, monkeypatch, tmp_path):
    with installed_from(of_spec(tmp_path, "rover", SPEC), monkeypatch):
        Robot.objects.filter(pk=robot.pk).update(driver="rover", calibration={}, cycle=Cycle.READY)
        robot.refresh_from_db()
        Lease.objects.create(robot=robot, epoch=5, expires_at=clock.now() + timedelta(days=9))
        QueueRobot.objects.filter(robot=robot).update(guests_ask=True)
        yield robot


@pytest.fixture
def running(rover, clock):
    """Return a function that lets a job run on the robot, and returns the job and its command."""

    def run(kind="patrol"):
        job = ask(rover, GUEST, kind, {}, clock.now())
        queue.tick(clock.now())
        command = Command.objects.select_related("robot", "grant").get(ended_at=None)
        for state in (CommandState.ACCEPTED, CommandState.SENT, CommandState.ACKNOWLEDGED):
            rows.advance(command, state, clock.now())
        return job, command

    return run


@pytest.mark.parametrize("alone_s", [None, 0.0])
def test_a_cancelled_job_is_followed_until_its_robot_rests(rover, running, clock, alone_s):
    """Also where staff have just switched that off: what runs keeps what it began with."""
    job, command = running()
    if alone_s is not None:
        Robot.objects.update(settings={"alone_s": alone_s})
    later = ask(rover, OTHER, "go", {}, clock.now())
    cancel(job, GUEST, clock.go(1))
    grant = services.open_grant(rover)
    assert (grant.kind, grant.holder, grant.opened_at) == (GrantKind.REST, None, clock.now())
    assert grant.until == clock.now() + timedelta(seconds=MOST_S + REST_S)
    assert why_not_ready(rover, clock.now()) == "The robot comes to rest."
    assert status_of(rover, clock.now())[:2] == ("handover", "Comes to rest")
    queue.tick(clock.go(MOST_S))
    later.refresh_from_db()
    assert (later.state, services.open_grant(rover)) == ("waiting", grant)
    rows.finish(command, CommandState.CANCELLED, clock.now(), "The robot's time for this is over.")
    services.end_grant(grant, GrantEnd.FINISHED, "at rest", clock.now())  # as the robot's owner does
    queue.tick(clock.now())
    job.refresh_from_db()
    later.refresh_from_db()
    assert (job.state, later.state) == ("cancelled", "running")


def test_idle_behaviour_gives_way_to_a_job_once_it_rests(rover, clock, people):
    grant = services.start_grant(rover, GrantKind.IDLE, clock.now(), until=clock.now() + timedelta(minutes=1))
    command = put(rover, grant, "patrol", {}, 60.0, clock.now())
    rows.advance(command, CommandState.ACCEPTED, clock.now())
    job = ask(rover, GUEST, "go", {}, clock.now())
    queue.tick(clock.now())
    job.refresh_from_db()
    assert (job.state, services.open_grant(rover).kind) == ("waiting", GrantKind.REST)
    rows.finish(command, CommandState.CANCELLED, clock.now())
    services.end_grant(services.open_grant(rover), GrantEnd.FINISHED, "at rest", clock.now())
    queue.tick(clock.now())
    job.refresh_from_db()
    assert job.state == "running"


@pytest.mark.parametrize("case", ["another kind", "not begun", "over"])
def test_nothing_follows_where_the_robot_rests_by_itself(rover, running, clock, case):
    job, command = running("go" if case == "another kind" else "patrol")
    if case == "not begun":
        Command.objects.update(state=CommandState.QUEUED)
    elif case == "over":
        rows.finish(command, CommandState.COMPLETED, clock.now())
    cancel(job, GUEST, clock.go(1))
    assert services.open_grant(rover) is None


def test_its_owner_is_gone_so_it_ends_by_the_time_it_rests(rover, running, clock):
    job, _ = running()
    cancel(job, GUEST, clock.now())
    Lease.objects.update(expires_at=clock.now())
    queue.tick(clock.go(MOST_S + REST_S - 0.1))
    assert services.open_grant(rover).kind == GrantKind.REST
    queue.tick(clock.go(0.2))
    assert services.open_grant(rover) is None
    assert Grant.objects.get(kind=GrantKind.REST).end_code == GrantEnd.TIME_UP


def test_staff_begin_nothing_else_meanwhile(rover, running, clock, people):
    job, _ = running()
    cancel(job, GUEST, clock.now())
    with pytest.raises(NotPermitted, match="comes to rest"):
        configure(rover, people["kim"], "tone", {"pitch": 440.0}, clock.now())
    with pytest.raises(NotPermitted, match="comes to rest"):
        services.start_grant(rover, GrantKind.STAFF, clock.now(), people["kim"])


def test_a_lock_out_leaves_it_open(rover, running, clock, people):
    running()
    services.lock_out(rover, people["kim"], "something lies in the hall")
    assert services.open_grant(rover).kind == GrantKind.REST
    assert Grant.objects.get(kind=GrantKind.JOB).end_code == GrantEnd.LOCKED_OUT


def test_staff_who_lock_it_out_to_drive_it_read_that_it_is_locked_out(rover, running, people):
    running()
    Lease.objects.update(expires_at=SYSTEM.now() + timedelta(days=9))  # pages have the true time
    form = {"from": "first", "note": "something lies in the hall"}
    page = signed_in(people["kim"]).post(f"/admin/robots/robot/{rover.pk}/do/maintenance/", form, follow=True)
    assert page.redirect_chain[-1][0] == "/admin/"
    assert "Locked out. People keep their places. The robot comes to rest after" in page.content.decode()
    assert Robot.objects.get(pk=rover.pk).lockout_note == form["note"]
    assert form["note"] in LogEntry.objects.get().change_message
