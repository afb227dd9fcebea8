"""The admin says commands, incidents, pieces, queues and numbers as people do, in the reader's language."""

import re
from datetime import timedelta

import pytest

from operatorlog.models import Find, Piece, Round
from queueing.models import Account, Job, Queue, Ticket, Turn
from queueing.services import queue_of
from robots.admin.words import INCIDENTS
from robots.kit.clock import SYSTEM
from robots.kit.contract.errors import HardwareFault
from robots.models import Command, Grant, Incident, Lease, Robot
from robots.services.incidents import UNTIDY
from robots.services.outages import CODE
from robots.states import CommandState, GrantKind
from tests.services.browsers import signed_in

pytestmark = [pytest.mark.service, pytest.mark.django_db, pytest.mark.usefixtures("owned")]


@pytest.fixture
def root(django_user_model):
    return django_user_model.objects.create_superuser("root", "root@example.org", "correct horse 42")


@pytest.fixture
def german(root):
    return signed_in(root, headers={"accept-language": "de"})


def commanded(robot, kind, args=None, end=""):
    now = SYSTEM.now()
    grant = Grant.objects.create(
        robot=robot, kind=GrantKind.UPKEEP, opened_at=now, ended_at=now, end_code="finished", end_reason=end
    )
    return Command.objects.create(
        robot=robot, grant=grant, client_seq=1, kind=kind, args=args or {}, epoch=1, state=CommandState.COMPLETED,
        created_at=now, deadline=now + timedelta(seconds=9), clamping={"speed": [0.5, 0.25]},
    )  # fmt: skip


def cells(page, column):
    """Return the texts of a column of a list."""
    found = re.findall(rf'<t[hd] class="field-{column}[^"]*">(.*?)</t[hd]>', page, re.DOTALL)
    return [re.sub("<[^>]*>", "", cell) for cell in found]


def test_commands_are_said_in_words_wherever_the_admin_tells_them(robot, german):
    made = commanded(robot, "air", {"seconds": 0.5})
    calibration = commanded(robot, "calibrate")
    page = german.get("/admin/robots/command/").text
    assert cells(page, "kind") == ["Kamera kalibrieren", "0,5 s lang Luft blasen"]
    assert "0,25 statt 0,5" in cells(page, "clamped")[0]
    assert "Luft (air)" in page, "a filter has the code beside"
    assert f"Luft #{made.pk}" in german.get(f"/admin/robots/command/{made.pk}/change/").text
    status = german.get(f"/admin/robots/robot/{robot.pk}/status/").text
    assert "0,5 s lang Luft blasen: Fertig" in status and "Kamera kalibrieren: Fertig" in status
    assert not re.search(r"\b(air|calibrate)\b", status)
    Command.objects.filter(pk=calibration.pk).update(kind="of_an_older_version")
    assert "Of an older version" in german.get("/admin/robots/command/").text


def test_the_end_of_a_grant_for_one_command_is_said_in_words(robot, german):
    commanded(robot, "bury", end="bury: completed")
    assert cells(german.get("/admin/robots/grant/").text, "end_reason") == ["Neu vergraben: Fertig"]


def test_the_kind_of_a_job_is_said_in_words(robot, root, german):
    queue = queue_of(robot)
    account = Account.objects.create(queue=queue, user=root, finish_tag=51.782887)
    Job.objects.create(robot=robot, queue=queue, account=account, kind="bury", asked_at=SYSTEM.now(), start_tag=1 / 3)
    page = german.get("/admin/queueing/job/").text
    assert cells(page, "kind") == ["Neu vergraben"]
    assert cells(page, "start_tag") == ["0,3333"]
    assert cells(german.get("/admin/queueing/account/").text, "used") == ["51,78"]


def test_the_code_of_an_incident_is_said_in_words(robot, german):
    one = Incident.objects.create(robot=robot, at=SYSTEM.now(), code="camera_fault", text="It is dark.")
    for page in ("/admin/robots/incident/", f"/admin/robots/incident/{one.pk}/change/"):
        text = german.get(page).text
        assert "Kamera" in text
        assert "camera_fault" not in re.sub("<[^>]*>", "", text), page


def test_each_code_of_an_incident_has_words():
    found, faults = set(), [HardwareFault]
    while faults:
        fault = faults.pop()
        faults += fault.__subclasses__()
        found.add(fault.code)
    assert {*found, UNTIDY, CODE, "microphone", "stop_failed"} <= set(INCIDENTS)


def test_pieces_and_places_of_finds_are_in_the_readers_language(robot, root, german):
    one, now = Round.objects.create(robot=robot, number=2, began_at=SYSTEM.now()), SYSTEM.now()
    piece = Piece.objects.create(round=one, name="bag", x=0.1, y=0.2)
    turn_grant = commanded(robot, "bury").grant
    turn = Turn.objects.create(
        robot=robot, user=root, grant=turn_grant, started_at=now, base_until=now, until=now, last_seen=now, ended_at=now
    )
    find = Find.objects.create(
        round=one, turn=turn, author=root, name="x", x=0.226, y=0.2, seen_at=now, reported_at=now,
        state=Find.State.CONFIRMED, piece=piece,
    )  # fmt: skip
    page = german.get("/admin/operatorlog/find/").text
    assert cells(page, "place") == ["x 22,6 cm, y 20,0 cm"]
    assert cells(page, "piece") == ["Tasche"]
    page = german.get(f"/admin/operatorlog/find/{find.pk}/change/").text
    assert "Tasche, 12,6 cm entfernt" in page
    assert "x 22,6 cm, y 20,0 cm" in page


def test_measured_values_on_a_robots_page_have_the_readers_decimal_mark(robot, german):
    Lease.objects.update(state={"joints": [], "pose": [0.1, 0.42, 0.075, 0]}, state_at=SYSTEM.now())
    status = german.get(f"/admin/robots/robot/{robot.pk}/status/").text
    assert "y 0,42 m" in status and "0.42" not in status


def test_the_name_of_a_queue_is_in_the_readers_language(robot, root, german):
    queue, now = queue_of(robot), SYSTEM.now()
    Ticket.objects.create(queue=queue, user=root, start_tag=51.782887, joined_at=now, last_seen=now)
    for page in ("/admin/queueing/queue/", "/admin/queueing/ticket/", f"/admin/queueing/queue/{queue.pk}/change/"):
        text = german.get(page).text
        assert f"Warteschlange von {robot.name}" in text, page
    assert cells(german.get("/admin/queueing/ticket/").text, "start_tag") == ["51,78"]
    Queue.objects.update(name="The long one")
    assert "The long one" in german.get("/admin/queueing/queue/").text


def test_a_robots_state_has_the_words_of_its_card(robot, german, root):
    for changes, english, other in (
        ({}, "Ready", "Bereit"),
        ({"stop_latched": True, "stopped_at": SYSTEM.now()}, "Stopped", "Angehalten"),
        ({"cycle": "locked_out", "stop_latched": False}, "Locked out", "Gesperrt"),
    ):
        Robot.objects.filter(pk=robot.pk).update(**changes)
        for client, words in ((signed_in(root), english), (german, other)):
            assert f'<span class="pill">{words}</span>' in client.get("/admin/live/").text
            page = client.get("/admin/robots/robot/").text
            assert cells(page, "state") == [words]
            assert cells(page, "stop") == [words if "stopped_at" in changes else "-"]
            assert re.search(rf"<dd>{words}\b", client.get(f"/admin/robots/robot/{robot.pk}/status/").text)
