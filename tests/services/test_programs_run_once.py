"""A program that has begun is never begun again by itself; a goal is, and so is a program that never began."""

import pytest
from django.db import Error, OperationalError

from queueing import services as queue
from queueing.models import Job
from queueing.services import ask
from robots import services
from robots.kit.contract.errors import HardwareFault, MotionHeld, OutOfWorkspace
from robots.kit.contract.session import Outcome, Progress
from robots.models import Command
from robots.states import CommandState, GrantEnd
from tests.services.owner import made_owner
from tests.services.test_jobs import GUEST, settle
from tests.services.test_jobs_of_programs import TEXT, scout  # noqa: F401 - a fixture
from workers.commands import rows

pytestmark = [pytest.mark.service, pytest.mark.django_db(transaction=True)]
AT = "step 3 of 4: turn 90"
ONCE = "It is not begun again by itself, and costs nothing."


def running(robot, clock, kind="mission"):
    """Return a job that runs, and its command."""
    job = ask(robot, GUEST, kind, {"text": TEXT} if kind == "mission" else {}, clock.now())
    queue.tick(clock.now())
    return job, Command.objects.select_related("robot", "grant").get(ended_at=None)


def begun(command, clock):
    """Let the robot say that it has understood."""
    for state in (CommandState.ACCEPTED, CommandState.SENT, CommandState.ACKNOWLEDGED):
        rows.advance(command, state, clock.go(1))


def cut_off(command, clock, code, why):
    """End the grant of a command that has begun, and then the command, at a step."""
    begun(command, clock)
    services.end_grant(command.grant, code, why, clock.now())
    rows.finish(command, CommandState.CANCELLED, clock.now(), "The robot's time for this is over.", at=AT)
    queue.tick(clock.now())


def runs(job):
    job.refresh_from_db()
    return job.state, job.charged, job.runs.count()


@pytest.mark.parametrize("state", ["failed", "cancelled", "expired"])
def test_a_mission_that_had_begun_has_failed_with_the_fault_and_costs_nothing(scout, clock, state):  # noqa: F811
    job, command = running(scout, clock)
    begun(command, clock)
    settle(clock, state, "Step 3 of 4, turn 90: The line is lost.")
    assert runs(job) == ("failed", 0.0, 1)
    assert job.reason == f"Step 3 of 4, turn 90: The line is lost. {ONCE}"
    queue.tick(clock.go(60))
    assert runs(job) == ("failed", 0.0, 1), "a second tick"
    assert job.account.finish_tag == 0.0


@pytest.mark.parametrize("state", ["failed", "rejected", "expired", "cancelled"])
def test_a_mission_that_never_began_waits_again_and_three_times_at_most(scout, clock, state):  # noqa: F811
    job, _ = running(scout, clock)
    settle(clock, state, "The line is lost.")
    assert runs(job) == ("running", None, 2)
    settle(clock, state, "The line is lost.")
    settle(clock, state, "The line is lost.")
    assert runs(job) == ("failed", 0.0, 3)


def test_a_mission_that_gives_way_after_it_began_is_not_begun_again(scout, clock):  # noqa: F811
    job, command = running(scout, clock)
    cut_off(command, clock, GrantEnd.PREEMPTED, "the robot's own need comes first: dock")
    assert runs(job) == ("failed", 0.0, 1)
    needed = "Interrupted, because the robot's own need comes first: dock."
    assert job.reason == f"{needed} It was at {AT}. {ONCE}"


def test_a_mission_that_is_too_long_says_at_which_step_and_is_charged(scout, clock):  # noqa: F811
    job, command = running(scout, clock)
    cut_off(command, clock, GrantEnd.TIME_UP, "time is up")
    assert runs(job) == ("failed", 1.0, 1)
    assert job.reason == f"It took longer than a job is allowed to. The robot's time for this is over. It was at {AT}."


def test_what_is_no_program_is_a_goal_and_waits_again_after_it_began(scout, clock):  # noqa: F811
    job, command = running(scout, clock, "rest")
    begun(command, clock)
    settle(clock, "failed", "The line is lost.")
    assert runs(job) == ("running", None, 2)


class Tours:
    """A driver for `made_owner` that runs a mission, at whose second step something happens."""

    def __init__(self, owner, happens):
        self.happens, self.arm = happens, owner.owned.driver
        self.arm.execute = self

    def __call__(self, kind, args, permit, on_stage):
        permit()
        on_stage("sent")
        on_stage("acknowledged")
        on_stage(Progress("step 1 of 2: photograph", 0.0))
        on_stage(Progress("step 2 of 2: turn 90", 0.5))  # too soon after it for the row, but not for the package
        self.happens()
        return Outcome({}, self.arm.latest())


@pytest.fixture
def owner(robot, people):
    return made_owner(robot, people)


def carried_out(owner, people, text="photograph\nturn 90"):
    slug, now = owner.owned.robot.slug, owner.owned.now()
    command = services.issue(slug, people["ada"], "mission", {"text": text}, 1, now).command
    owner.motion.run_one(command)
    command.refresh_from_db()
    return command


def raises(error):
    def happens():
        raise error

    return happens


@pytest.mark.parametrize("which", ["srv1"], indirect=True)
@pytest.mark.parametrize(
    ("error", "state", "words"),
    [
        (HardwareFault("The line is lost."), "failed", "The line is lost. It was at step 2 of 2: turn 90."),
        (HardwareFault("Step 2 of 2, turn 90: The line is lost."), "failed", "Step 2 of 2, turn 90: The line is lost."),
        (OutOfWorkspace("No way."), "rejected", "No way. It was at step 2 of 2: turn 90."),
        (OperationalError("gone"), "unknown", "It was at step 2 of 2: turn 90."),
    ],
)
def test_whatever_ends_a_program_its_step_is_named_once(owner, people, monkeypatch, error, state, words):
    monkeypatch.setattr(owner.runner, "_on_fault", lambda error, command: None)
    Tours(owner, raises(error))
    command = carried_out(owner, people)
    assert (command.state, command.reason.endswith(words)) == (state, True), command.reason
    assert command.reason.lower().count("step 2 of 2") == 1


@pytest.mark.parametrize("which", ["srv1"], indirect=True)
def test_the_step_is_named_after_a_lost_lease(owner, people):
    Tours(owner, lambda: setattr(owner.lease, "epoch", owner.lease.epoch + 1))
    command = carried_out(owner, people)
    assert (command.state, command.reason.endswith("It was at step 2 of 2: turn 90.")) == ("unknown", True)


@pytest.mark.parametrize("which", ["srv1"], indirect=True)
def test_that_a_program_began_is_known_although_the_database_was_away_then(owner, people, monkeypatch):
    away = []

    def advanced(*given):
        if len(away) < 2:
            away.append(given)
            raise Error("away")
        return advance(*given)

    advance = rows.advance
    monkeypatch.setattr(rows, "advance", advanced)
    Tours(owner, raises(HardwareFault("The line is lost.")))
    monkeypatch.setattr(owner.runner, "_on_fault", lambda error, command: None)
    command = carried_out(owner, people)
    assert (len(away), command.state) == (2, "failed")
    assert command.sent_at is not None


@pytest.mark.parametrize("which", ["srv1"], indirect=True)
def test_a_program_that_an_owner_left_behind_names_its_step_without_the_package_too(owner, people, robot):
    slug, now = owner.owned.robot.slug, owner.owned.now()
    command = services.issue(slug, people["ada"], "mission", {"text": "photograph"}, 1, now).command
    told = {"state": "sent", "progress": {"text": "step 1 of 1: photograph, more", "share": 0.0}}
    Command.objects.filter(pk=command.pk).update(**told)
    rows.abandon(robot, now)
    command.refresh_from_db()
    assert command.reason.endswith("It was at step 1 of 1: photograph.")
    assert Job.objects.count() == 0


@pytest.mark.parametrize("which", ["srv1"], indirect=True)
@pytest.mark.parametrize("seconds", [None, 12.0])
def test_an_owner_that_ends_writes_no_end_of_what_goes_on_without_it(owner, people, seconds):
    """The row tells whoever follows that the robot may move, until it has been asked."""

    def ends():
        owner.owned.running = False
        owner.owned.driver.rests_within = lambda: seconds
        raise MotionHeld("held")

    Tours(owner, ends)
    assert carried_out(owner, people).state == ("acknowledged" if seconds else "cancelled")
