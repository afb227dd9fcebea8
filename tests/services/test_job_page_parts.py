"""What the page of a job shows to everybody: its kind in words, every stage of every run, progress, and the result."""

from datetime import timedelta

import pytest
from django.core import mail
from django.test import Client
from django.utils import translation

from portal.keep.seeding import add_robot
from portal.web.jobs.words import request_in_words, result, stages
from queueing import services as queue
from queueing.models import Job
from queueing.services import Asker, ask
from robots.grants import end_grant
from robots.kit.clock import SYSTEM
from robots.models import Command
from robots.states import CommandState, GrantEnd
from tests.services.browsers import signed_in
from tests.services.test_jobs import GUEST, settle
from workers.commands import rows

pytestmark = pytest.mark.django_db


@pytest.fixture
def job(shuttle, people, clock):
    """A job of Ada's that has begun: accepted, sent and under way, a second after each other."""
    found = ask(shuttle, Asker(user=people["ada"]), "go", {"x": 1.0}, clock.now(), mail=True)
    queue.tick(clock.now())
    run(clock)
    return found


def run(clock):
    """Do what the owner does at the beginning of a command; return the command."""
    command = Command.objects.select_related("robot", "grant").get(ended_at=None)
    assert rows.claim(command, command.epoch, clock.go(1))
    for state in (CommandState.SENT, CommandState.ACKNOWLEDGED):
        rows.advance(command, state, clock.go(1))
    return command


def page(job, client=None):
    return (client or Client()).get(job.get_absolute_url())


def table(answer):
    """Return run, stage and note of each row of the table of stages."""
    return [(number, stage.words, stage.note) for number, found in answer.context["runs"] for stage in found]


def test_its_kind_is_called_what_the_robot_calls_it(shuttle, job, people, clock, django_capture_on_commit_callbacks):
    assert b"<h1>Drive to on Mercury " in page(job).content
    listed = Client().get("/robots/mercury/jobs/").content
    assert b">Drive to</a>" in listed
    assert b">go</a>" not in listed
    with django_capture_on_commit_callbacks(execute=True):
        settle(clock)
    assert mail.outbox[0].body.startswith("Drive to: done.")
    Job.objects.update(ended_at=SYSTEM.now())
    ada = signed_in(people["ada"])
    assert b"Drive to, done" in ada.get("/story/").content


def test_a_kind_that_nobody_knows_any_more_keeps_its_name(shuttle, job):
    Job.objects.update(kind="hop")
    assert b"<h1>Hop on Mercury " in page(job).content


def test_every_stage_of_every_run_is_shown_with_its_time(shuttle, job, people, clock):
    begun = [(1, "Queued", ""), (1, "Accepted", ""), (1, "Sent", ""), (1, "Moving", "")]
    assert table(page(job)) == begun
    settle(clock, CommandState.FAILED, "The motor is hot.")
    run(clock)
    settle(clock)
    again = [(2, "Queued", ""), (2, "Accepted", ""), (2, "Sent", ""), (2, "Moving", ""), (2, "Done", "")]
    answer = page(job)
    assert table(answer) == [*begun, (1, "Failed", "The motor is hot."), *again]
    command = Command.objects.order_by("id").first()
    for stamp in (command.accepted_at, command.acknowledged_at, command.ended_at):
        assert f"{stamp:%H:%M:%S}" in answer.content.decode()


@pytest.mark.service
def test_its_progress_is_shown_in_words_and_as_a_share_and_is_kept(shuttle, job, clock):
    at = clock.go(1)
    told = {"text": "12 s of at most 60 s", "share": 0.2, "at_ms": int(at.timestamp() * 1000)}
    Command.objects.update(progress=told)
    answer = page(job)
    assert table(answer)[-1] == (1, "Under way", "12 s of at most 60 s (20 %)")
    assert b'<progress max="1" value="0.2" aria-label="How much of it is done">' in answer.content
    settle(clock)
    answer = page(job)
    assert [row[1:] for row in table(answer)][-2:] == [("Under way", "12 s of at most 60 s (20 %)"), ("Done", "")]
    assert b"<progress" not in answer.content, "it is over"


@pytest.mark.django_db
def test_where_to_and_what_came_of_it_are_told_in_plain_words_of_the_readers_language():
    """The iRat's: which place of which map it was are numbers of its own, which people do not choose by."""
    job = Job(robot=add_robot("irat"), kind="goal", args={"map": 1, "x": -0.0054, "y": 1.5, "experience": 24})
    progress = {"text": "21 s of at most 104 s", "share": 0.2}
    sent = {"map": 1, "experience": 24, "limit_s": 103.9}
    done = Command(created_at=SYSTEM.now(), state="completed", progress=progress, result={"sent": sent})
    assert request_in_words(job, texts=False) == [
        ("", "0.5 cm left of where its map began"), ("", "1.5 m up from where its map began"),
    ]  # fmt: skip
    assert result(job, done, texts=False) == [("Time limit (s)", "103.9")]
    with translation.override("de"):
        said = request_in_words(job, texts=False)
        assert not any("began" in words for _, words in said), said
        assert result(job, done, texts=False) == [("Time limit (s)", "103,9")]
        assert [stage.note for stage in stages(done)] == ["", "21 s von höchstens 104 s (20 %)"]


@pytest.mark.service
@pytest.mark.parametrize(
    ("value", "words"),
    [(183.5602539, "183.6 m"), (16_777_216.0, "16777216 m"), (0.05, "0.05 m"), (1234.56, "1235 m"), (-2.0, "-2 m")],
)
def test_a_measured_number_is_shown_with_few_digits_and_kept_with_all(shuttle, job, clock, value, words):
    settle(clock, sent={"x": value})
    assert page(job).context["result"] == [("x", words)]
    assert Command.objects.order_by("id").first().result["sent"]["x"] == value


def test_what_gave_way_to_somebody_else_is_told_calmly(shuttle, job, clock):
    grant = Command.objects.get().grant
    end_grant(grant, GrantEnd.PREEMPTED, "somebody's turn comes next", clock.now())
    command = Command.objects.select_related("robot", "grant").get()
    assert rows.finish(command, CommandState.CANCELLED, clock.go(1), "The robot's time for this is over.")
    assert table(page(job))[-1] == (1, "Interrupted", "Interrupted, because somebody's turn comes next.")
    queue.tick(clock.now())
    job.refresh_from_db()
    assert (job.state, job.faults) == ("running", 0), "it keeps its place, and goes on"


@pytest.mark.parametrize("told", [{"text": "on its way", "share": None, "at_ms": 1}, {"text": "on its way"}])
def test_progress_without_a_share_or_a_time_is_shown_too(shuttle, job, told):
    Command.objects.update(progress=told)
    answer = page(job)
    assert (1, "Under way", "on its way") in table(answer)
    assert b"<progress" not in answer.content


def test_its_result_is_shown_with_units_and_with_what_was_measured(shuttle, job, clock):
    assert page(job).context["result"] == []
    settle(
        clock, sent={"x": 0.98, "limit_s": 3.5}, channels={"began": {"battery": 0.8}, "ended": {"battery": 0.75}},
        verdict="stable",
    )  # fmt: skip
    assert page(job).context["result"] == [
        ("x", "0.98 m"), ("limit_s", "3.5"), ("battery at its end", "0.75"), ("picture", "stable"),
    ]  # fmt: skip
    assert b"<li>x: 0.98 m</li>" in page(job).content


def test_a_failed_job_shows_what_was_measured_and_texts_stay_with_its_asker(shuttle, people, job, clock):
    settle(
        clock, CommandState.FAILED, "A leaf lies on the rail.", code="gave_up", sent={"note": "for my aunt"},
        channels={"began": {}, "ended": {"driven": 2.0}},
    )  # fmt: skip
    job.refresh_from_db()
    assert job.state == "failed"
    assert page(job).context["result"] == [("driven at its end", "2 m")]
    ada = signed_in(people["ada"])
    assert page(job, ada).context["result"] == [("note", "for my aunt"), ("driven at its end", "2 m")]


def test_a_guests_page_has_all_of_it_too(shuttle, clock):
    found = ask(shuttle, GUEST, "go", {"x": 1.0}, clock.now())
    queue.tick(clock.now())
    settle(clock, sent={"x": 1.0})
    answer = page(found)
    assert answer.context["result"] == [("x", "1 m")]
    assert [words for _, words, _ in table(answer)] == ["Queued", "Done"]
    assert timedelta(0) < clock.now() - found.asked_at
