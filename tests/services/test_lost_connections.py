"""The list of an operator's lost connections: bounded, for the operator and staff."""

import pytest
from django.test import Client

from queueing import own_place
from queueing import services as queue
from queueing.models import SIDES, LostCause, LostConnection
from robots.kit.clock import SYSTEM
from robots.states import GrantEnd
from tests.services.turns import drive

pytestmark = [pytest.mark.service, pytest.mark.django_db]


@pytest.fixture
def turn(robot, people, owned):
    return drive(robot, people["ada"], SYSTEM.now())


def lose(turn, cause="cut", who=None):
    queue.note_disconnection(turn.robot, who or turn.user, SYSTEM.now(), cause=cause)


def page(person, turn):
    client = Client()
    if person is not None:
        client.force_login(person)
    return client.get(turn.get_absolute_url()).content.decode()


def test_the_operator_and_staff_read_cause_and_side_and_others_do_not(turn, people, django_user_model):
    lose(turn, "restart")
    root = django_user_model.objects.create_superuser("root", "root@example.org", "correct horse 42")
    for person in (people["ada"], root):
        text = page(person, turn)
        assert "Lost connections" in text
        assert "The portal was restarted" in text
        assert "<td>portal</td>" in text
    for person in (None, people["bob"], people["mod"]):
        assert "Lost connections" not in page(person, turn)
    staff = Client()
    staff.force_login(root)
    assert "The portal was restarted" in staff.get("/admin/queueing/lostconnection/").content.decode()


def test_a_page_that_reconnects_all_the_time_adds_few_rows(turn, monkeypatch):
    monkeypatch.setattr(own_place, "MOST_LOST", 3)
    for _ in range(9):
        lose(turn)
    assert turn.lost_connections.count() == 3


def test_only_known_causes_of_the_operator_in_a_running_turn_are_listed(turn, people):
    lose(turn, "")
    lose(turn, "anything")
    lose(turn, "cut", people["bob"])
    queue.end_turn(turn, GrantEnd.HOLDER, "ended", SYSTEM.now())
    lose(turn)
    assert not LostConnection.objects.exists()
    assert SIDES.keys() == set(LostCause)
