"""What staff may ask of a robot beside its commands: no button for what the robot cannot do."""

from types import SimpleNamespace

import pytest

from robots import services
from robots.admin import verbs
from robots.kit.contract.capabilities import Reset
from robots.kit.contract.errors import BadRequest
from robots.kit.contract.find import function, spec_of
from robots.kit.contract.procedures import offered_procedures
from robots.kit.contract.session import Session
from robots.kit.installed import driver_path
from robots.models import Command, Grant, Lease, Robot
from robots.services import RobotOffline
from robots.states import Cycle
from tests.services.browsers import signed_in

pytestmark = [pytest.mark.service, pytest.mark.django_db, pytest.mark.usefixtures("installed", "owned")]
HAVE = {"mercury": ["soft_reset", "calibrate", "still"], "turntable": []}
which = pytest.mark.parametrize("which", ["turntable"], indirect=True)


def asked(robot, user, **told):
    return (Robot.objects.get(pk=robot.pk), SimpleNamespace(user=user, POST=told))


@pytest.mark.parametrize("which", HAVE, indirect=True)
def test_what_is_offered_is_what_the_robot_has(robot):
    assert [p.kind for p in offered_procedures(robot.driver)] == HAVE[robot.driver]


@pytest.mark.parametrize("name", ["mercury", "pa10", "irat", "turntable"])
def test_a_reset_is_declared_where_the_session_has_one_of_its_own(name):
    own = function(driver_path(name)).recover is not Session.recover
    assert (spec_of(name).capability(Reset) is not None) is own


@which
@pytest.mark.parametrize("kind", ["soft_reset", "calibrate", "still"])
def test_what_it_cannot_do_is_refused_before_anything_is_opened(robot, people, kind):
    Robot.objects.update(cycle=Cycle.READY)
    with pytest.raises(BadRequest):
        services.staff_command(robot, people["kim"], kind)
    with pytest.raises(BadRequest, match="no such procedure"):
        verbs.procedure(*asked(robot, people["kim"], kind=kind))
    assert not (Command.objects.exists() or Grant.objects.exists())


@which
def test_a_test_of_a_robot_without_a_camera_asks_for_no_picture(robot, people):
    Robot.objects.update(cycle=Cycle.READY, enabled=True)
    said = verbs.test(*asked(robot, people["kim"]))
    assert "its worker answers" in said
    assert "asked for" not in said
    assert not Command.objects.exists()
    Lease.objects.update(expires_at=None)
    with pytest.raises(RobotOffline):
        verbs.test(*asked(robot, people["kim"]))


@pytest.mark.parametrize("which", ["mercury"], indirect=True)
def test_a_test_of_a_robot_with_a_camera_takes_a_picture(robot, people):
    Robot.objects.update(cycle=Cycle.READY, enabled=True)
    assert "a new picture was asked for" in verbs.test(*asked(robot, people["kim"]))
    assert Command.objects.get().kind == "still"


@pytest.mark.parametrize("which", HAVE, indirect=True)
def test_the_pages_name_no_procedure_that_it_does_not_have(robot, people):
    client = signed_in(people["kim"])
    page = client.get(f"/admin/robots/robot/{robot.pk}/change/").content.decode()
    assert ('value="soft_reset"' in page) is ("soft_reset" in HAVE[robot.driver])
    public = client.get(f"/robots/{robot.slug}/").content.decode()
    assert ("Take a picture" in public) is ("still" in HAVE[robot.driver])
