"""A kind of command has a level, which the operator's clearance must reach."""

from datetime import timedelta

import pytest

from accounts.models import Clearance
from portal.live.actions import act
from portal.live.messages import Command as Asked
from portal.web.pages.views import console_facts
from robots import services
from robots.kit.clock import SYSTEM
from robots.models import Command, Robot
from robots.services.permissions import NotCleared
from robots.states import Cycle, GrantKind
from tests.services.browsers import signed_in

pytestmark = [
    pytest.mark.service, pytest.mark.django_db, pytest.mark.usefixtures("installed"),
    pytest.mark.parametrize("which", ["turntable"], indirect=True),
]  # fmt: skip


@pytest.fixture
def drive(robot, owned):
    """Give somebody the turn; return a function that asks for a kind of command."""
    numbers = iter(range(1, 99))

    def given(user):
        if grant := services.open_grant(robot):
            services.end_grant(grant, "holder", "test", SYSTEM.now())
        services.start_grant(robot, GrantKind.TURN, SYSTEM.now(), user, SYSTEM.now() + timedelta(minutes=5))
        Robot.objects.update(cycle=Cycle.OPERATING)
        return lambda kind, **args: services.issue(robot.slug, user, kind, args, next(numbers)).command

    return given


def test_a_kind_above_the_clearance_is_refused_in_words(drive, people):
    asked = drive(people["ada"])
    assert asked("home").state == "queued"
    with pytest.raises(NotCleared, match="Fling needs a clearance of level 2"):
        asked("fling")
    assert not Command.objects.filter(kind="fling").exists()


def test_a_clearance_of_that_level_is_enough_until_it_is_withdrawn(drive, people, robot):
    higher = Clearance.objects.create(user=people["ada"], robot=robot, level=2, granted_at=SYSTEM.now())
    asked = drive(people["ada"])
    assert asked("fling").state == "queued"
    higher.revoked_at = SYSTEM.now()
    higher.save()
    with pytest.raises(NotCleared):
        asked("fling")


def test_staff_of_the_robot_need_none(drive, people):
    assert drive(people["kim"])("fling").state == "queued"
    with pytest.raises(NotCleared):
        drive(people["mod"])("fling")


def test_the_level_costs_nothing_where_it_is_one(drive, people, django_assert_num_queries):
    asked = drive(people["ada"])
    asked("home")
    with django_assert_num_queries(4):  # the open grant, and the row in its savepoint
        asked("home")


def test_the_socket_answers_with_the_sentence(drive, people, robot, monkeypatch):
    drive(people["ada"])
    monkeypatch.setattr("portal.live.actions.current_user", lambda scope: people["ada"])
    answer = act({}, robot.slug, Asked(kind="fling", args={}, seq=1))
    assert (answer.ok, answer.code) == (False, "not_cleared")
    assert "level 2" in answer.text


def test_the_console_offers_what_the_clearance_reaches(people, robot):
    def offered(user):
        return {c["kind"] for c in console_facts(robot, user)["commands"]}

    assert "fling" not in offered(people["ada"])
    Clearance.objects.create(user=people["ada"], robot=robot, level=2, granted_at=SYSTEM.now())
    assert "fling" in offered(people["ada"])
    assert offered(people["kim"]) - offered(people["ada"]) == {"sway"}
    client = signed_in(people["bob"])
    assert '"kind": "fling"' not in client.get(f"/robots/{robot.slug}/").content.decode()
