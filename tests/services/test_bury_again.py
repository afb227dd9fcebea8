"""Bury again: the next round has another bed, which the portal asks the simulator for; its places are told to nobody."""

import json
import re

import pytest
from django.contrib.admin.models import LogEntry

from operatorlog import finds
from operatorlog.models import Round
from portal.live.snapshot import snapshot
from portal.run.processes import robot_processes
from queueing.models import Turn
from robots import services as robots
from robots.grants import end_grant, start_grant
from robots.kit.clock import SYSTEM
from robots.kit.contract.errors import NotPermitted
from robots.kit.drivers.mercury.pieces import pieces
from robots.models import Command
from robots.states import GrantEnd, GrantKind
from tests.services.conftest import ROLES
from tests.services.finds import PAGES, SECRET, as_role, bed_of, confirmed, ended

pytestmark = [pytest.mark.service, pytest.mark.django_db]


@pytest.fixture
def bed(robot, roles):
    return bed_of(robot)


def page_of(one):
    return f"/admin/operatorlog/round/{one.pk}/bury/"


def bury(roles, role, chosen, **told):
    told = {
        "puzzle": "Another story?",
        "pieces": "copper bell\n brass  key \n\n",
        "bed": chosen.command_id or "",
    } | told
    return as_role(roles, role).post(page_of(chosen), told, follow=True)


def test_a_form_that_was_opened_before_somebody_else_buried_changes_nothing(bed, roles):
    assert "nothing was changed." in bury(roles, "superuser", bed, bed=0).content.decode()
    assert Round.objects.get().ended_at is None


@pytest.mark.parametrize("simulated", [True, False])
def test_bury_again_ends_the_round_once_and_it_becomes_a_milestone(bed, roles, client, robot, simulated):
    if not simulated:
        type(robot).objects.filter(pk=robot.pk).update(address="serial:/dev/ttyUSB0")
    confirmed(roles)
    Round.objects.update(puzzle="Which story?")
    assert "Buried again: the next round has begun." in bury(roles, "superuser", bed).content.decode()
    assert "nothing was changed." in bury(roles, "superuser", bed).content.decode(), "a second press"
    bed.refresh_from_db()
    present = Round.objects.get(ended_at=None)
    assert (present.number, present.puzzle, present.begun_by) == (2, "Another story?", roles["superuser"])
    assert bed.puzzle == "Which story?"
    assert bed.ended_at == present.began_at
    if simulated:
        assert hidden_in(present) == pieces_of(robot.rig_secret, 2)
        command = Command.objects.get(kind="bury")
        assert (present.command, command.args, command.lane) == (command, {"number": 2}, "config")
        assert (command.grant.kind, command.issued_by) == (GrantKind.UPKEEP, roles["superuser"])
    else:
        assert {name: (x, y) for name, x, y in hidden_in(present)} == dict.fromkeys(
            ("copper bell", "brass key"), (None, None)
        )
        assert not Command.objects.filter(kind="bury").exists()
    assert LogEntry.objects.filter(object_id=bed.pk, user=roles["superuser"]).count() == 1
    html = client.get("/robots/mercury/finds/").content.decode()
    assert "Milestones" in html
    assert f"0 of {9 if simulated else 2} pieces were found in round 2" in html
    assert "1 of 2 pieces was found." in html
    assert "thimble" not in html
    now, _, before = html.partition("Milestones")
    assert ("Another story?" in now, "Which story?" in before) == (True, True)
    assert "Which story?" not in now


@pytest.mark.parametrize(
    ("told", "said"),
    [
        ({"puzzle": " "}, "This field is required."),
        ({"puzzle": "\u200b"}, "Say in at most 300 characters what people are asked to find out."),
        ({"puzzle": "x" * 301}, "at most 300 characters"),
        ({"pieces": " "}, "This field is required."),
        ({"pieces": "bell\nbell"}, "Name the pieces, one to 100, each in at most 80 characters, and no two alike."),
        ({"pieces": "x" * 81}, "Name the pieces"),
    ],
)
def test_without_puzzle_or_pieces_nothing_is_buried_and_what_was_typed_stays(bed, roles, robot, told, said):
    type(robot).objects.filter(pk=robot.pk).update(address="serial:/dev/ttyUSB0")
    answer = bury(roles, "superuser", bed, **told)
    assert answer.status_code == 422
    assert said in answer.content.decode()
    assert ("copper bell" in answer.content.decode()) == ("pieces" not in told)
    bed.refresh_from_db()
    assert bed.ended_at is None
    assert Round.objects.count() == 1


@pytest.mark.parametrize("simulated", [True, False])
def test_the_page_shows_the_old_puzzle_and_pieces_and_has_room_for_new_ones(bed, roles, robot, simulated):
    if not simulated:
        type(robot).objects.filter(pk=robot.pk).update(address="serial:/dev/ttyUSB0")
    Round.objects.update(puzzle="Which story?")
    client = as_role(roles, "superuser")
    answer = client.get(page_of(bed))
    html = answer.content.decode()
    assert "<p>Which story?</p>" in html
    assert all(f"<li>{name}</li>" in html for name in SECRET)
    assert {name: field.value() for name, field in fields(answer)} == dict.fromkeys(
        ["puzzle"] if simulated else ["puzzle", "pieces"]
    )
    assert f'href="{page_of(bed)}"' in client.get(f"/admin/operatorlog/round/{bed.pk}/change/").content.decode()
    assert f'href="{page_of(bed)}"' in client.get(f"/admin/robots/robot/{robot.pk}/change/").content.decode()
    data = {"action": "bury_again", "_selected_action": bed.pk}
    assert client.post("/admin/operatorlog/round/", data)["Location"] == page_of(bed)
    kim = as_role(roles, "robot_staff")
    assert "/bury/" not in kim.get(f"/admin/robots/robot/{robot.pk}/change/").content.decode()
    bury(roles, "superuser", bed)
    assert "/bury/" not in client.get(f"/admin/operatorlog/round/{bed.pk}/change/").content.decode()
    assert client.get(page_of(bed))["Location"].endswith(f"/{Round.objects.get(ended_at=None).pk}/change/")


def fields(answer):
    return [(field.name, field) for field in answer.context["form"]]


def test_the_story_tells_the_present_round_and_leads_to_its_finds(bed, roles, robot, client):
    Round.objects.update(puzzle="Which story?")
    confirmed(roles)
    story = client.get("/story/").content.decode()
    assert "Which story?" in story
    assert "1 of 2 pieces was found in round 1" in story
    assert "thimble" not in story
    bury(roles, "superuser", bed, puzzle="Another story?")
    story = client.get("/story/").content.decode()
    assert "Another story?" in story
    assert "Which story?" not in story
    assert "0 of 9 pieces were found in round 2" in story
    for page in ("/story/", f"/log/?robot={robot.slug}"):
        assert f'href="/robots/{robot.slug}/finds/"' in client.get(page).content.decode()
    assert "/finds/" not in client.get("/log/").content.decode()
    type(robot).objects.update(driver="irat")
    assert "lies in the sand" not in client.get("/story/").content.decode()


def test_the_first_round_of_a_simulated_bed_has_the_puzzle_of_its_robot(robot, roles):
    client = as_role(roles, "superuser")
    for typed, puzzle in (("", finds.excavation_of(robot).puzzle), ("Another?", "Another?")):
        client.post("/admin/operatorlog/round/add/", {"robot": robot.pk, "puzzle": typed})
        assert Round.objects.get().puzzle == puzzle != ""
        Round.objects.all().delete()
    robot.address = "serial:/dev/ttyUSB0"
    assert finds.begin_first(robot, SYSTEM.now()).puzzle == ""


def hidden_in(one):
    return {(piece.name, piece.x, piece.y) for piece in one.pieces.all()}


def pieces_of(secret, number):
    return {(piece.name, piece.x, piece.y) for piece in pieces(secret, number)}


def test_the_first_bed_of_an_installation_is_its_own(robot, owned, settings):
    first = finds.begin_first(robot, SYSTEM.now())
    assert hidden_in(first) == pieces_of(robot.rig_secret, 1)
    assert not hidden_in(first) & pieces_of("", 1), "those that are in the source"
    before = robot.rig_secret
    assert type(robot)(slug="mercury-practice").rig_secret != before
    settings.SECRET_KEY = "another installation's, long enough"
    assert robot.rig_secret != before


def test_a_simulator_is_given_its_secret_and_tells_it_to_nobody(robot):
    simulator, worker = robot_processes(robot)
    assert simulator.env["FARHAND_SIMULATOR_SECRET"] == robot.rig_secret
    assert not any(robot.rig_secret in word for one in (simulator, worker) for word in one.argv), "others see those"
    assert "FARHAND_SIMULATOR_SECRET" not in worker.env


def test_a_bed_that_was_not_made_is_asked_for_again_and_the_round_stays(bed, roles, robot):
    bury(roles, "superuser", bed)
    present = Round.objects.get(ended_at=None)
    first = present.command
    assert "nothing was changed" in bury(roles, "superuser", present).content.decode(), "it waits"
    Command.objects.filter(pk=first.pk).update(state="failed", reason="The line was silent.", ended_at=SYSTEM.now())
    end_grant(first.grant, GrantEnd.FINISHED, "", SYSTEM.now())
    client = as_role(roles, "superuser")
    assert "The line was silent." in client.get("/admin/operatorlog/round/").content.decode()
    answer = client.get(page_of(present))
    assert "The bed of round 2 of Mercury was not made" in answer.content.decode()
    assert [field.value() for _, field in fields(answer)] == ["Another story?"]
    assert "Buried again" in bury(roles, "superuser", present, puzzle="A third?").content.decode()
    again = Round.objects.get(ended_at=None)
    assert (again.pk, again.number, again.puzzle) == (present.pk, 2, "A third?")
    assert again.command != first
    assert again.command.args == {"number": 2}
    assert hidden_in(again) == pieces_of(robot.rig_secret, 2)


def test_while_somebody_uses_the_robot_or_nothing_reaches_it_nothing_is_buried(bed, roles, robot, owned):
    Turn.objects.update(ended_at=SYSTEM.now())
    grant = start_grant(robot, GrantKind.TURN, SYSTEM.now(), roles["operator"])
    assert "Somebody uses the robot" in bury(roles, "superuser", bed).content.decode()
    end_grant(grant, GrantEnd.FINISHED, "", SYSTEM.now())
    type(owned).objects.update(expires_at=None)
    bury(roles, "superuser", bed)
    bed.refresh_from_db()
    assert bed.ended_at is None
    assert Round.objects.count() == 1
    assert not Command.objects.filter(kind="bury").exists()


@pytest.mark.asvs("8.2.2")
def test_another_bed_is_asked_for_by_the_register_alone(bed, roles, robot):
    """Neither the operator nor staff give that command: the register would say other places than the sand has."""
    root = roles["superuser"]
    grant = start_grant(robot, GrantKind.STAFF, SYSTEM.now(), root)
    with pytest.raises(NotPermitted, match="by the portal alone"):
        robots.issue(robot.slug, root, "bury", {"number": 3}, robots.next_seq(grant))
    end_grant(grant, GrantEnd.FINISHED, "", SYSTEM.now())
    grant = start_grant(robot, GrantKind.TURN, SYSTEM.now(), roles["operator"])
    with pytest.raises(NotPermitted):
        robots.issue(robot.slug, roles["operator"], "bury", {"number": 3}, robots.next_seq(grant))
    end_grant(grant, GrantEnd.FINISHED, "", SYSTEM.now())
    client, page = as_role(roles, "superuser"), f"/admin/robots/robot/{robot.pk}"
    assert 'value="bury"' not in client.get(f"{page}/change/").content.decode()
    client.post(f"{page}/do/setting/", {"kind": "bury", "number": "3"})
    assert '"kind": "bury"' not in client.get("/robots/mercury/").content.decode()
    assert not Command.objects.filter(kind="bury").exists()


PUBLIC = ("/robots/mercury/statistics.json", "/robots/mercury/statistics/", "/statistics/", "/statistics.json",
          "/embed/robots/mercury/")  # fmt: skip


@pytest.mark.asvs("8.2.2")
@pytest.mark.parametrize("role", ["anonymous", "operator", "robot_staff"])
def test_no_place_of_a_new_bed_is_told_and_none_follows_from_what_is(bed, roles, robot, role):
    """Who reads all rows of the command, all pages and the source has no place: it takes the secret."""
    bury(roles, "superuser", bed)
    command = Command.objects.get(kind="bury")
    Command.objects.filter(pk=command.pk).update(
        state="completed", ended_at=SYSTEM.now(), result={"sent": command.args}, accepted_at=SYSTEM.now()
    )
    present = Round.objects.get(ended_at=None)
    known = [str(value) for row in Command.objects.filter(pk=command.pk).values() for value in row.values()]
    places = {(x, y) for _, x, y in hidden_in(present)}
    for guess in ("", robot.slug, "secret", *known):
        for number in (*range(1, 30), command.pk, present.pk):
            assert not places & {(x, y) for _, x, y in pieces_of(guess, number)}
    client = as_role(roles, role)
    told = [json.dumps(snapshot(robot.slug, roles[role], SYSTEM.now(), True), default=str)]
    for page in (*PAGES, *PUBLIC):
        told.append(client.get(ended().get_absolute_url() if page == "turn" else page, follow=True).content.decode())
    values = {value for at in places for part in at for value in (part, 100 * part, 1000 * part)}
    for text in (*told, *known):
        said = re.sub(r":\d\d\.\d+", "", text)  # seconds of times are like a place by chance
        assert robot.rig_secret not in said
        assert not {f"{value:.4g}" for value in values} & set(re.findall(r"-?\d+\.\d+", said))
        assert not any(f"{value:.3f}" in said for value in values)


@pytest.mark.asvs("8.2.2")
@pytest.mark.parametrize("role", [role for role in ROLES if role != "superuser"])
def test_nobody_without_the_permission_buries_again(bed, roles, role):
    bury(roles, role, bed)
    bed.refresh_from_db()
    assert bed.ended_at is None
    assert Round.objects.count() == 1
