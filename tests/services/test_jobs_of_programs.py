"""A job may name a saved program, as a command of a turn may."""

import json
from datetime import timedelta

import pytest
from django.contrib.auth.models import AnonymousUser
from django.test import Client

from queueing import services as queue
from queueing.models import Job, QueueRobot
from queueing.services import Asker, ask
from robots.kit.contract.errors import BadRequest
from robots.models import Lease, Program, Robot
from robots.services import programs
from tests.packaged import installed_from, of_spec

pytestmark = [pytest.mark.service, pytest.mark.django_db]
GUEST = Asker(guest="a" * 64, network="192.0.2.1")
TEXT = "roll 1\nturn 90"
SPEC = """
from robots.kit.contract.capabilities import Programs
from robots.kit.contract.spec import ANYONE, Argument, CommandKind, Spec
def spec():
    text = Argument("text", "", 1.0, 6000.0, text=True)
    run = CommandKind("mission", "Run a mission", (text,), asked_by=frozenset({ANYONE}))
    return Spec("Scout", (run, CommandKind("rest", "Rest", asked_by=frozenset({ANYONE}))),
                capabilities=(Programs("mission", "lines of its own"),))
"""


@pytest.fixture
def scout(robot, people, clock, monkeypatch, tmp_path):
    """A robot that takes missions from everybody, guests too."""
    with installed_from(of_spec(tmp_path, "scout", SPEC), monkeypatch):
        Robot.objects.filter(pk=robot.pk).update(driver="scout", calibration={})
        robot.refresh_from_db()
        Lease.objects.create(robot=robot, epoch=5, expires_at=clock.now() + timedelta(days=9))
        QueueRobot.objects.filter(robot=robot).update(offers_turns=False, guests_ask=True, charged_in="jobs")
        yield robot


@pytest.fixture
def saved(scout, people, clock):
    def save(who, name="Round", gallery=False):
        made = programs.save(scout, people[who], name, TEXT, gallery, clock.now())
        Program.objects.filter(pk=made.pk).update(approved=gallery)
        return made.pk

    return save


def test_a_person_asks_for_a_mission_that_they_saved_and_its_text_of_then_is_run(scout, saved, people, clock):
    pk = saved("ada")
    job = ask(scout, Asker(user=people["ada"]), "mission", {"program": pk}, clock.now())
    assert job.args == {"text": TEXT}
    programs.save(scout, people["ada"], "Round", "roll 9", False, clock.now(), pk)
    queue.tick(clock.now())
    command = job.runs.get().grant.commands.get()
    assert (command.kind, command.args) == ("mission", {"text": TEXT}), "as it was when it was asked for"


def test_nobody_asks_for_what_another_has_not_shared(scout, saved, people, clock):
    pk = saved("ada")
    for asker in (Asker(user=people["bob"]), GUEST):
        with pytest.raises(BadRequest, match="no such program, or it is not shared"):
            ask(scout, asker, "mission", {"program": pk}, clock.now())
    assert not Job.objects.exists()


def test_a_guest_asks_for_one_of_the_gallery(scout, saved, people, clock):
    pk = saved("ada", gallery=True)
    assert ask(scout, GUEST, "mission", {"program": pk}, clock.now()).args == {"text": TEXT}
    assert [p.pk for p in programs.visible(scout, None)] == [pk]
    saved("ada", "Another")
    for nobody in (None, AnonymousUser()):
        assert [p.pk for p in programs.visible(scout, nobody)] == [pk]


@pytest.mark.parametrize("program", [True, None, "1", 1.5, 2**63, -1, [1]])
def test_what_names_no_program_is_refused_in_words(scout, people, clock, program):
    with pytest.raises(BadRequest, match=r"\.$"):
        ask(scout, GUEST, "mission", {"program": program}, clock.now())
    with pytest.raises(BadRequest, match=r"\.$"):
        ask(scout, GUEST, "rest", {"program": program}, clock.now())
    assert not Job.objects.exists()


def test_the_page_offers_the_saved_programs_and_refuses_others_in_words(scout, saved, people, client):
    mine, hers = saved("ada"), saved("bob", "Secret")
    client.force_login(people["ada"])
    page = client.get("/robots/mercury/jobs/").content.decode()
    assert f'<option value="{mine}">Round</option>' in page
    assert "Secret" not in page
    for sent, status in (({"program": hers}, 400), ({"program": "x"}, 400), ({"arg-text": ""}, 400)):
        answer = client.post("/robots/mercury/jobs/", {"kind": "mission", **sent})
        assert (answer.status_code, b'role="alert"' in answer.content) == (status, True), sent
    told = client.post(
        "/robots/mercury/jobs/", {"kind": "mission", "program": mine}, headers={"accept": "application/json"}
    )
    assert (told.status_code, told.json()["args"]) == (201, {"text": TEXT})
    assert client.post("/robots/mercury/jobs/", {"kind": "mission", "arg-text": "roll 2"}).status_code == 302


def test_a_guests_page_offers_the_gallery_alone(scout, saved):
    pk = saved("ada", gallery=True)
    saved("bob", "Secret")
    guest = Client()
    page = guest.get("/robots/mercury/jobs/").content.decode()
    assert f'<option value="{pk}">Round</option>' in page and "Secret" not in page
    answer = guest.post("/robots/mercury/jobs/", {"kind": "mission", "program": pk})
    assert (answer.status_code, Job.objects.get().args) == (302, {"text": TEXT})


def test_ones_own_programs_stand_before_a_gallery_that_is_longer_than_the_list(scout, saved, people, client, clock):
    made = [Program(robot=scout, name=f"A {n}", text=TEXT, approved=True, changed_at=clock.now()) for n in range(201)]
    Program.objects.bulk_create(made)
    mine = saved("ada", "Zebra")
    assert programs.visible(scout, people["ada"])[0].pk == mine
    client.force_login(people["ada"])
    page = client.get("/robots/mercury/jobs/").content.decode()
    assert f'<option value="{mine}">Zebra</option>' in page
    assert "2 more are in the gallery" in page
    told = client.get("/robots/mercury/programs/").json()["programs"]
    assert (len(told), told[0]["id"]) == (200, mine)


HIDDEN = "# {}\nroll 1"  # a comment, which no checker of programs looks into


@pytest.mark.parametrize("never", ["\0", "\ud800"], ids=["NUL", "half a letter"])
def test_a_text_that_no_database_stores_is_refused_however_it_is_sent(scout, saved, people, clock, client, never):
    text = HIDDEN.format(never)
    with pytest.raises(BadRequest, match="cannot be stored"):
        ask(scout, GUEST, "mission", {"text": text}, clock.now())
    client.force_login(people["ada"])
    for choice in (json.dumps({"text": text}), json.dumps({"text": "roll 1"})):
        answer = client.post("/robots/mercury/jobs/", {"kind": "mission", "choice": choice})
        assert answer.status_code == 400, "this robot offers no choices"
    assert not Job.objects.exists()
