"""Staff alone may have an arm tidy its table; what was left between two turns is one incident."""

import pytest

from queueing.services import Asker, ask
from robots import services
from robots.kit.clock import SYSTEM
from robots.kit.contract.errors import NotPermitted, RobotError, Stopped
from robots.models import Command, Grant, Incident, Robot
from robots.services.incidents import note_tidy, note_untidy
from robots.states import Cycle, GrantKind
from tests.services.browsers import signed_in

pytestmark = [pytest.mark.service, pytest.mark.django_db, pytest.mark.parametrize("which", ["pa10"], indirect=True)]


@pytest.mark.parametrize("name", ["ada", "eve", "mod"])
def test_others_than_staff_of_robots_are_refused_in_every_way(robot, people, owned, name):
    person = people[name]
    with pytest.raises(NotPermitted):
        services.staff_command(robot, person, "tidy")
    with pytest.raises(RobotError):
        ask(robot, Asker(user=person), "tidy", {}, SYSTEM.now())
    client = signed_in(person)
    assert client.post(f"/admin/robots/robot/{robot.pk}/do/procedure/", {"kind": "tidy"}).status_code in (302, 403)
    services.start_grant(robot, GrantKind.TURN, SYSTEM.now(), person)
    with pytest.raises(NotPermitted, match="The command tidy is for staff"):
        services.issue(robot.slug, person, "tidy", {"seconds": 60.0}, 1)
    assert not Command.objects.exists()


def test_staff_press_its_button_on_the_page_of_the_robot(robot, people, owned):
    client = signed_in(people["kim"])
    assert "Tidy the table" in client.get(f"/admin/robots/robot/{robot.pk}/change/").text
    said = client.post(f"/admin/robots/robot/{robot.pk}/do/procedure/", {"kind": "tidy"}, follow=True)
    assert "Tidy the table: queued" in said.text
    command = Command.objects.get()
    assert (command.kind, command.issued_by, command.grant.kind) == ("tidy", people["kim"], GrantKind.UPKEEP)
    with pytest.raises(NotPermitted, match="A command of staff runs"):
        services.staff_command(robot, people["kim"], "tidy")


def test_it_takes_the_arm_from_nobody_and_does_not_begin_under_a_stop(robot, people, owned):
    Robot.objects.update(cycle=Cycle.OPERATING)
    turn = services.start_grant(robot, GrantKind.TURN, SYSTEM.now(), people["ada"])
    with pytest.raises(NotPermitted, match="Somebody operates the robot now"):
        services.staff_command(robot, people["kim"], "tidy")
    assert Grant.objects.get().pk == turn.pk
    Grant.objects.update(ended_at=SYSTEM.now())
    Robot.objects.update(stop_latched=True)
    with pytest.raises(Stopped):
        services.staff_command(robot, people["kim"], "tidy")
    assert not Command.objects.exists()


def test_its_progress_and_what_it_left_stand_on_the_page(robot, people, owned):
    left = "Red was not brought back: the pictures do not show it."
    command = services.staff_command(robot, people["kim"], "tidy")
    Command.objects.filter(pk=command.pk).update(
        state="failed", reason=left, progress={"text": "3 of 4 are in their places"}
    )
    page = signed_in(people["kim"]).get(f"/admin/robots/robot/{robot.pk}/status/").text
    assert "Tidy the table: Failed, 3 of 4 are in their places" in page
    assert left in page


def test_what_was_left_is_one_incident_until_everything_is_in_its_place(robot):
    for text in ("Red was not brought back: x.", "Blue was not brought back: y."):
        note_untidy(robot, text, SYSTEM.now())
    assert [one.text for one in Incident.objects.all()] == ["Red was not brought back: x."]
    note_tidy(robot, SYSTEM.now())
    assert Incident.objects.get().closed_at is not None
    note_untidy(robot, "Blue was not brought back: y.", SYSTEM.now())
    assert Incident.objects.filter(closed_at=None).count() == 1
