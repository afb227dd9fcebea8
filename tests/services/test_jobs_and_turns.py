"""Jobs beside a turn: an operator does not drive for ever while another person's job waits; no asker is named."""

import json

import pytest
from django.contrib.auth.models import AnonymousUser

from portal.live.snapshot import snapshot
from queueing import services as queue
from queueing.models import Job, QueueRobot, Turn
from queueing.services import Asker, ask, forecast, resume
from robots import services
from robots.grants import stage_event
from robots.models import Command, Grant, Robot
from robots.states import Cycle
from tests.services.turns import drive

pytestmark = pytest.mark.django_db
GUEST = Asker(guest="a" * 64, network="192.0.2.1")


@pytest.fixture
def turns_of_a_minute(shuttle):
    Robot.objects.update(turn_s=60)


@pytest.fixture
def driven(shuttle, people, clock):
    """The shuttle, which ada drives."""
    QueueRobot.objects.update(offers_turns=True)
    Robot.objects.update(cycle=Cycle.READY)
    drive(shuttle, people["ada"], clock.now())
    return shuttle


def drive_on(robot, people, clock, seconds, every=1):
    """Let time pass in which ada's page stays connected; the queue is looked at each `every` seconds."""
    for _ in range(0, seconds, every):
        queue.note_presence(robot, people["ada"], clock.go(every), classic=False)
        queue.tick(clock.now())


@pytest.mark.usefixtures("turns_of_a_minute")
def test_a_turn_goes_on_while_nobody_waits_and_ends_after_somebody_asks_for_a_job(driven, people, clock):
    drive_on(driven, people, clock, 100, every=4)
    assert Turn.objects.get().ended_at is None, "extended: nobody waits"
    ask(driven, GUEST, "go", {"x": 1.0}, clock.now())
    drive_on(driven, people, clock, 62, every=2)
    turn = Turn.objects.get()
    assert (turn.ended_at is not None, turn.end_reason) == (True, "time is up")


def test_an_operator_who_does_nothing_makes_room_for_a_job(driven, people, clock):
    ask(driven, GUEST, "go", {"x": 1.0}, clock.now())
    drive_on(driven, people, clock, 125, every=5)
    assert Turn.objects.get().end_reason == "idle while others wait"


@pytest.mark.usefixtures("turns_of_a_minute")
def test_ones_own_job_ends_no_turn_of_ones_own(driven, people, clock):
    Job.objects.create(
        queue=queue.queue_of(driven), robot=driven, user=people["ada"], kind="go", args={"x": 1.0}, start_tag=0.0,
        asked_at=clock.now(), account=queue.queue_of(driven).accounts.get(user=people["ada"]),
    )  # fmt: skip
    drive_on(driven, people, clock, 150, every=5)
    assert Turn.objects.get().ended_at is None


@pytest.mark.usefixtures("turns_of_a_minute")
def test_a_job_that_waits_for_staff_ends_no_turn(driven, people, clock):
    services.stop(driven, people["ada"], clock.now())
    services.release_stop(driven, people["ada"], checked=True)
    driven.refresh_from_db()
    ask(driven, GUEST, "go", {"x": 1.0}, clock.now())
    drive_on(driven, people, clock, 150, every=5)
    assert Turn.objects.get().ended_at is None


def test_who_did_nothing_while_jobs_waited_for_staff_is_not_idle_when_they_are_resumed(driven, people, clock):
    services.stop(driven, people["ada"], clock.now())
    services.release_stop(driven, people["ada"], checked=True)
    driven.refresh_from_db()
    ask(driven, GUEST, "go", {"x": 1.0}, clock.now())
    drive_on(driven, people, clock, 150, every=5)
    resume(driven, people["kim"], clock.now())
    drive_on(driven, people, clock, 115, every=5)
    assert Turn.objects.get().ended_at is None, "two minutes are counted while others wait for the turn"
    drive_on(driven, people, clock, 10, every=5)
    assert Turn.objects.get().end_reason == "idle while others wait"


def test_the_wait_for_a_job_counts_the_turn(driven, people, clock):
    ask(driven, GUEST, "go", {"x": 1.0}, clock.now())
    (first,) = forecast(driven, clock.now())
    assert first.wait_s == (12, 312), "a handover at least, the whole turn at most"
    drive_on(driven, people, clock, 100, every=4)
    (first,) = forecast(driven, clock.now())
    assert first.wait_s == (12, 212)


def test_who_asked_for_a_job_and_their_texts_are_told_to_nobody(shuttle, people, clock):
    ask(shuttle, Asker(user=people["bob"]), "go", {"x": 1.0}, clock.now())
    queue.tick(clock.now())
    sent = {"x": 1.0, "note": "for my aunt", "steps": [{"say": "aunt", "n": 2}, "aunt"]}
    Command.objects.update(result={"sent": sent, "verdict": "stable"})
    command = Command.objects.select_related("grant").get()
    assert command.issued_by == people["bob"]
    for viewer in (AnonymousUser(), people["eve"]):
        shown = snapshot(shuttle.slug, viewer, clock.now(), True)
        (told,) = shown["commands"]
        assert told["by"] == ""
        assert told["result"] == {"sent": {"x": 1.0, "steps": [{"n": 2}]}, "verdict": "stable"}
        assert "aunt" not in json.dumps(shown["commands"])
    assert "aunt" not in str(stage_event(command).result)


def test_who_drives_is_named_beside_their_commands(driven, people, clock):
    grant = Grant.objects.get(ended_at=None)
    Command.objects.create(
        robot=driven, grant=grant, client_seq=1, kind="go", issued_by=people["ada"], created_at=clock.now(),
        deadline=clock.now(), epoch=5,
    )  # fmt: skip
    assert [c["by"] for c in snapshot(driven.slug, AnonymousUser(), clock.now(), True)["commands"]] == ["ada"]
