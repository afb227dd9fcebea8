"""Who may ask what over a socket: every message of both sockets by every role; one without a row fails."""

from types import SimpleNamespace

import pytest
from django.conf import settings
from django.db import transaction

from portal.live import actions, standing
from portal.live.messages import Accept, Command, Join, Leave, PersonMessage, Release, RobotMessage, Stop, Trace
from queueing.models import Ticket
from robots.kit.clock import SYSTEM
from tests.services.browsers import signed_in
from tests.services.conftest import ROLES

pytestmark = pytest.mark.django_db

DRIVES = ("operator",)
STOPS = ("operator", "robot_staff", "superuser")
KEEPS = ("robot_staff", "superuser")
# message: who is answered with yes. The operator's turn is open, nobody else waits.
ASKS = {
    Command: (Command(kind="up", seq=7), DRIVES),
    Stop: (Stop(), STOPS),
    Release: (Release(checked=True), STOPS),
    Trace: (Trace(on=True), KEEPS),
    Join: (Join(), ("cleared", "operator")),
    Leave: (Leave(), tuple(role for role in ROLES if role != "anonymous")),  # where there is no place, nothing happens
    Accept: (Accept(), ("operator",)),
}
# who is told or asks nothing of the robot: presence, whose pictures, keep-alives of one's own held motion; a preview
# is for cleared people and judged where it is computed; a cheer is for whoever watches: tests/faults/test_cheers.py
ELSEWHERE = {"Ping", "Watch", "Keep", "Released", "Plan", "Cheer"}
PERSON = {"Here", "Look", "Do"}


def test_promise_35_every_message_is_in_the_table():
    assert {one.__name__ for one in RobotMessage.__args__} == {one.__name__ for one in ASKS} | ELSEWHERE
    assert {one.__name__ for one in PersonMessage.__args__} == PERSON


@pytest.fixture
def scopes(roles):
    """Return what a socket of each role knows: the cookie of a session."""
    made = {}
    for role, user in roles.items():
        client = signed_in(user)
        key = client.session.session_key if user.is_authenticated else ""
        made[role] = {"cookies": {settings.SESSION_COOKIE_NAME: key}}
    return made


@pytest.mark.asvs("8.2.1", "8.2.2", "8.3.1")
@pytest.mark.parametrize("kind", ASKS, ids=lambda kind: kind.__name__)
def test_promise_35_messages_by_roles(robot, scopes, kind):
    message, may = ASKS[kind]
    for role in ROLES:
        with transaction.atomic():
            answer = actions.act(scopes[role], robot.slug, message)
            transaction.set_rollback(True)
        assert answer.ok is (role in may), f"{role}: {answer.text}"
        assert answer.ok or answer.text, f"{role}: a refusal has a sentence"


@pytest.mark.asvs("7.4.1", "8.3.1")
@pytest.mark.parametrize("kind", ASKS, ids=lambda kind: kind.__name__)
def test_promise_34_a_session_that_ended_asks_nothing(robot, roles, scopes, kind):
    from django.contrib.sessions.models import Session

    Session.objects.all().delete()
    for role in ROLES:
        answer = actions.act(scopes[role], robot.slug, ASKS[kind][0])
        assert (answer.ok, answer.code) == (False, "signed_out"), role


@pytest.mark.asvs("8.2.2")
@pytest.mark.parametrize("what", ["join", "leave", "accept", "dismiss"])
def test_promise_35_the_persons_socket_touches_ones_own_places_only(robot, roles, what):
    held = Ticket.objects.get(user=roles["operator"])
    for role in ROLES:
        if role == "anonymous":
            continue
        with transaction.atomic():
            wrong = standing.act(roles[role], what, robot.slug, held.pk, SYSTEM.now())
            after = SimpleNamespace(**Ticket.objects.filter(pk=held.pk).values("state", "dismissed_at").get())
            transaction.set_rollback(True)
        if role != "operator":
            assert (after.state, after.dismissed_at) == (held.state, None), role
        if what == "join":
            assert bool(wrong) is (role not in ("cleared", "operator")), role
        if what == "accept":
            assert bool(wrong) is (role != "operator"), role
