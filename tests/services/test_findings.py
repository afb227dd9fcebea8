"""What a long mission finds: it takes pictures although it has many readings, and its page counts omitted ones."""

from datetime import timedelta

import cv2
import numpy as np
import pytest

from queueing.jobs.running import promote
from queueing.models import QueueRobot, Turn
from queueing.services import Asker, ask
from robots import services
from robots.kit.contract.session import Observation, Outcome
from robots.models import Command, Finding, Frame, Lease
from robots.recordings.findings import SHOWN
from tests.services.owner import made_owner
from workers.commands import findings
from workers.commands.rows import finish
from workers.media.pictures import Pictures

JPEG = cv2.imencode(".jpg", np.full((240, 320, 3), 120, np.uint8))[1].tobytes()
pytestmark = [pytest.mark.service, pytest.mark.django_db(transaction=True)]


@pytest.fixture
def which(request):
    return getattr(request, "param", "srv1")


@pytest.fixture
def carried_out(robot, people, settings, tmp_path):
    """Let an owner carry out a mission that notes what is given; return its command."""
    settings.MEDIA_ROOT, settings.VAR = tmp_path / "media", tmp_path / "var"
    owner = made_owner(robot, people)
    arm, runner = owner.owned.driver, owner.runner
    arm.picture = lambda view, seconds: JPEG
    pictures = Pictures(robot, owner.owned.clock, lambda view, seconds: JPEG)
    runner._findings = findings.Findings(owner.owned, pictures, tmp_path / "findings")

    def carry_out(noted):
        def execute(kind, args, permit, on_stage):
            permit()
            for one in ("sent", "acknowledged", *noted):
                on_stage(one)
            return Outcome({}, arm.latest())

        arm.execute = execute
        now = owner.owned.now()
        command = services.issue(robot.slug, people["ada"], "mission", {"text": "photograph"}, 1, now).command
        owner.motion.run_one(command)
        command.refresh_from_db()
        assert command.state == "completed", command.reason
        return command

    return carry_out


def texts(command):
    return [(one.text, one.frame is not None) for one in Finding.objects.filter(command=command).order_by("number")]


READING, PHOTO = Observation("reading", {"sonar": 1.0}), Observation("photograph", photograph=True)


def test_a_photograph_after_many_readings_is_taken_and_what_is_left_out_is_counted(carried_out, monkeypatch):
    monkeypatch.setattr(findings, "MOST", 3)
    command = carried_out([*[READING] * 5, PHOTO, READING, PHOTO])
    spent = (findings.SPENT, False)
    assert texts(command) == [*[("reading", False)] * 3, spent, *[("photograph", True)] * 2]
    assert command.result["left_out"] == 3
    assert Frame.objects.filter(command=command).count() == 2


def test_pictures_have_a_limit_of_their_own(carried_out, monkeypatch):
    monkeypatch.setattr(findings, "MOST_PICTURES", 1)
    command = carried_out([PHOTO, PHOTO, READING, PHOTO])
    assert texts(command) == [("photograph", True), (findings.SPENT_PICTURES, False), ("reading", False)]
    assert command.result["left_out"] == 2


def test_where_nothing_is_left_out_nothing_is_said(carried_out):
    assert "left_out" not in carried_out([READING, PHOTO]).result


def test_as_many_values_are_stored_as_a_robot_can_have_channels(carried_out):
    values = {f"channel {n}": float(n) for n in range(255)}
    assert Finding.objects.get(command=carried_out([Observation("readings", values)])).values == values


@pytest.fixture
def job(robot, people, clock):
    """A job of ada's that has ended, its command, and how it is given findings."""
    Lease.objects.get_or_create(robot=robot, defaults={"epoch": 5, "expires_at": clock.now() + timedelta(days=9)})
    QueueRobot.objects.filter(robot=robot).update(guests_ask=True)
    made = ask(robot, Asker(user=people["ada"]), "mission", {"text": "photograph"}, clock.now())
    promote(made.queue, made, clock.now())
    command = Command.objects.select_related("robot", "grant").get(grant=made.runs.get().grant)

    def found(readings, photographs, stills=0, **result):
        rows = [Finding(command=command, number=n, at=clock.now(), text=f"no {n}") for n in range(1, readings + 1)]
        Finding.objects.bulk_create(rows)
        for n in range(photographs):
            fields = {"robot": robot, "grant": command.grant, "command": command, "taken_at": clock.now()}
            frame = Frame.objects.create(file=f"frames/{n}.jpg", **fields)
            number = readings + n + 1
            Finding.objects.create(command=command, number=number, at=clock.now(), text="photograph", frame=frame)
        for n in range(stills):
            Frame.objects.create(robot=robot, grant=command.grant, file=f"frames/s{n}.jpg", taken_at=clock.now())
        finish(command, "completed", clock.go(1), "", result)
        return made

    return found


def test_the_page_of_a_job_says_how_much_more_there_is_and_shows_all(job, people, client):
    client.force_login(people["ada"])
    address = job(SHOWN - 100, SHOWN, stills=SHOWN + 40, left_out=12).get_absolute_url()
    page = client.get(address).content.decode()
    assert "The first 200 of 300 are shown" in page
    assert "Below are the first 200 of 240 pictures" in page
    assert "12 more were not stored" in page
    assert ("no 100" in page, page.count("Picture 101"), page.count("Picture 201")) == (True, 1, 0)
    assert page.count("<img") == 100 + 200, "each picture of what it found beside that, and the others once"
    assert 'href="?all=1"' in page
    whole = client.get(f"{address}?all=1").content.decode()
    assert (whole.count("Picture 300"), whole.count("<img")) == (1, 200 + 240)
    assert "are shown" not in whole and "12 more were not stored" in whole


def test_a_job_that_found_little_says_nothing_of_more(job, people, client):
    client.force_login(people["ada"])
    made = job(3, 2)
    page = client.get(made.get_absolute_url()).content.decode()
    assert not any(words in page for words in ("are shown", "not stored", "?all=1", "<h2>Pictures"))
    assert "photograph</span>" in page
    client.logout()
    page = client.get(made.get_absolute_url()).content.decode()
    assert "What was written is shown to its author only." in page and "No values." not in page


@pytest.mark.parametrize("which", ["mercury"], indirect=True)
def test_the_page_of_a_turn_says_it_too(roles, robot, clock, client):
    turn, now = Turn.objects.get(), clock.now()
    command = Command.objects.create(
        robot=robot, grant=turn.grant, client_seq=1, kind="move", epoch=1, state="completed",
        created_at=now, deadline=now, result={"left_out": 5},
    )  # fmt: skip
    Finding.objects.bulk_create(Finding(command=command, number=n, at=now, text="") for n in range(1, SHOWN + 51))
    client.force_login(roles["operator"])
    page = client.get(f"/turns/{turn.pk}/").content.decode()
    assert "The first 200 of 250 are shown" in page and "5 more were not stored" in page
    assert (page.count("nothing measured"), 'href="?all=1"' in page) == (200, True)
    assert client.get(f"/turns/{turn.pk}/?all=1").content.decode().count("nothing measured") == 250
