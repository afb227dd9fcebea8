"""Who may do what: every public function of the services, and every verb of the admin, by every role.

A function that is in no table fails the test, so nobody adds a verb without saying who may use it.
"""

import contextlib
import inspect
from types import SimpleNamespace

import pytest
from django.core.exceptions import PermissionDenied
from django.db import transaction

from accounts import services as accounts
from accounts import staff as accounts_staff
from accounts.models import Choice, Clearance, Question
from operatorlog import services as log
from operatorlog.models import Entry, Visibility
from queueing import presence
from queueing import services as queue
from queueing import staff as queue_staff
from queueing.errors import QueueError
from queueing.models import Turn
from robots import bus, programs, services, verbs
from robots.clock import SYSTEM
from robots.drivers.errors import BadRequest, NotPermitted
from robots.models import Command, Incident, Program
from tests.services.conftest import ROLES

pytestmark = [pytest.mark.service, pytest.mark.django_db]
REFUSED = (NotPermitted, QueueError, log.LogError, accounts.NotNow, PermissionDenied)

NOBODY, ANYBODY = frozenset(), frozenset(ROLES)
SIGNED_IN = ANYBODY - {"anonymous"}
OPERATOR, CLEARED = frozenset({"operator"}), frozenset({"cleared", "operator"})
ROBOT_STAFF = frozenset({"robot_staff", "superuser"})
MODERATORS = frozenset({"log_moderator", "superuser"})
ADMINS = frozenset({"superuser"})


def turn(w):
    return Turn.objects.get(ended_at=None)


def over(w):
    one = turn(w)
    queue.end_turn(one, "over", SYSTEM.now())
    one.refresh_from_db()
    return one


def entry(w):
    one = over(w)
    return Entry.objects.create(turn=one, author=one.user, robot=w.robot, text="x", written_at=SYSTEM.now())


def locked(w):
    services.lock_out(w.robot, w.root, "cleaning")
    w.robot.refresh_from_db()
    return w.robot


def program(w, author="operator", **fields):
    return Program.objects.create(
        robot=w.robot, author=w.cast[author], name="p", text="down", changed_at=SYSTEM.now(), **fields
    )


def offered(w):
    over(w)
    type(w.robot).objects.update(cycle="ready")
    if w.user.is_authenticated and accounts.cleared(w.user, w.robot):
        queue.join(w.robot, w.user, SYSTEM.now())
    queue.tick(SYSTEM.now())
    return w.robot


def held(w):
    return Clearance.objects.get(user=w.cast["cleared"])


def refused():
    raise NotPermitted


def signed(w):
    """The pages ask for these about people who have signed in, and never about others."""
    return None if w.user.is_authenticated else refused()


def an_attempt(w, user):
    if not Question.objects.exists():
        right = Question.objects.create(robot=w.robot, text="?")
        Choice.objects.create(question=right, text="!", correct=True)
    accounts.mark_read(user, w.robot, SYSTEM.now())
    return accounts.begin(user, w.robot, SYSTEM.now())


# function: (who may, the call)
ROWS = {
    "robots.services.resolve": (ANYBODY, lambda w: services.resolve(w.robot, w.user, "down", {})),
    "robots.services.grant_of": (OPERATOR, lambda w: services.grant_of(w.robot, w.user, SYSTEM.now())),
    "robots.services.issue": (OPERATOR, lambda w: services.issue(w.robot.slug, w.user, "down", {}, 7)),
    "robots.services.preview": (SIGNED_IN, lambda w: said(BadRequest, services.preview, w.robot, w.user, "down", {}, ())),
    "robots.services.may_stop": (ANYBODY, lambda w: services.may_stop(w.robot, w.user)),
    "robots.services.stop": (OPERATOR | ROBOT_STAFF, lambda w: services.stop(w.robot, w.user)),
    "robots.services.release_stop": (OPERATOR | ROBOT_STAFF, lambda w: services.release_stop(w.robot, w.user, True)),
    "robots.services.lock_out": (ROBOT_STAFF, lambda w: services.lock_out(w.robot, w.user, "cleaning")),
    "robots.services.lift_lock_out": (ROBOT_STAFF, lambda w: services.lift_lock_out(locked(w), w.user)),
    "robots.services.start_maintenance": (ROBOT_STAFF, lambda w: services.start_maintenance(locked(w), w.user)),
    "robots.services.staff_command": (
        ROBOT_STAFF, lambda w: (over(w), services.staff_command(w.robot, w.user, "soft_reset")),
    ),
    "robots.services.set_enabled": (ROBOT_STAFF, lambda w: services.set_enabled(w.robot, w.user, False)),
    "robots.services.close_incident": (
        ROBOT_STAFF,
        lambda w: services.close_incident(Incident.objects.create(robot=w.robot, at=SYSTEM.now()), w.user),
    ),
    "robots.programs.visible": (ANYBODY, lambda w: list(programs.visible(w.robot, w.user))),
    "robots.programs.one": (OPERATOR, lambda w: refuse(BadRequest, programs.one, w.robot, w.user, program(w).pk)),
    "robots.programs.save": (
        SIGNED_IN, lambda w: programs.save(w.robot, w.user, "p", "down", False, SYSTEM.now()),
    ),
    "robots.programs.delete": (OPERATOR, lambda w: programs.delete(w.robot, w.user, program(w).pk)),
    "robots.programs.approve": (
        ADMINS, lambda w: programs.approve(program(w, shared=True), w.user, True),
    ),
    "accounts.services.cleared": (CLEARED, lambda w: accounts.cleared(w.user, w.robot) or refused()),
    "accounts.services.has_read": (SIGNED_IN, lambda w: (w.user.pk and accounts.has_read(w.user, w.robot)) or signed(w)),
    "accounts.services.mark_read": (SIGNED_IN, lambda w: accounts.mark_read(w.user, w.robot, SYSTEM.now())),
    "accounts.services.pause_left": (SIGNED_IN, lambda w: signed(w) or accounts.pause_left(w.user, w.robot, SYSTEM.now())),
    "accounts.services.withdrawn": (SIGNED_IN, lambda w: signed(w) or accounts.withdrawn(w.user, w.robot)),
    "accounts.services.begin": (SIGNED_IN, lambda w: an_attempt(w, w.user)),
    "accounts.services.grade": (OPERATOR, lambda w: accounts.grade(an_attempt(w, w.cast["operator"]), w.user, dict.fromkeys(Question.objects.values_list("pk", flat=True), 0), SYSTEM.now())),
    "accounts.staff.withdraw": (ADMINS, lambda w: accounts_staff.withdraw(held(w), w.user, "x", SYSTEM.now())),
    "accounts.staff.lift": (ADMINS, lambda w: accounts_staff.lift(held(w), w.user, "x", SYSTEM.now())),
    "queueing.services.open_ticket": (ANYBODY, lambda w: queue.open_ticket(w.robot, w.user)),
    "queueing.services.turn_of": (ANYBODY, lambda w: queue.turn_of(w.robot, w.user)),
    "queueing.services.join": (CLEARED, lambda w: queue.join(w.robot, w.user, SYSTEM.now())),
    "queueing.services.accept": (CLEARED, lambda w: queue.accept(offered(w), w.user, SYSTEM.now())),
    "queueing.services.seen": (ANYBODY, lambda w: queue.seen(w.robot, w.user, SYSTEM.now())),
    "queueing.services.leave": (ANYBODY, lambda w: queue.leave(w.robot, w.user, SYSTEM.now())),
    "queueing.staff.remove": (ROBOT_STAFF, lambda w: queue_staff.remove(turn(w).ticket, w.user, SYSTEM.now())),
    "queueing.staff.end": (ROBOT_STAFF, lambda w: queue_staff.end(turn(w), w.user, SYSTEM.now())),
    "operatorlog.services.write": (OPERATOR, lambda w: log.write(over(w), w.user, "x", None, SYSTEM.now())),
    "operatorlog.services.may_edit": (ANYBODY, lambda w: log.may_edit(entry(w), w.user, SYSTEM.now())),
    "operatorlog.services.edit": (OPERATOR, lambda w: log.edit(entry(w), w.user, "y", None, SYSTEM.now())),
    "operatorlog.services.moderate": (
        MODERATORS, lambda w: log.moderate(entry(w), w.user, Visibility.FEATURED, "", SYSTEM.now()),
    ),
    "operatorlog.services.answer_survey": (OPERATOR, lambda w: log.answer_survey(over(w), w.user, {}, SYSTEM.now())),
}  # fmt: skip
# steps and questions that no person asks for directly: they take none, and are called by what stands above
INNER = {
    "robots.services": {
        "owner_alive", "open_grant", "start_grant", "end_grant", "cancel_queued", "stage_event", "newest_still",
        "next_seq", "take_epoch",
    },
    "robots.programs": set(),
    "queueing.services": {
        "queue_of", "open_turn", "why_not_ready", "end_turn", "tick", "remove",
        # of the person of a request that has signed in, and of nobody else's rows
        "disconnected", "fresh_token", "spend_token",
    },
    "queueing.presence": {"present", "dismiss"},  # of one's own places, whoever one is
    "queueing.staff": set(),
    "accounts.services": {"in_words", "questions"},
    "accounts.staff": set(),
    "operatorlog.services": set(),
}  # fmt: skip


def said(kind, function, *arguments):
    """Call what says no to everybody for another reason than the person."""
    with contextlib.suppress(kind):
        function(*arguments)


def refuse(kind, function, *arguments):
    try:
        return function(*arguments)
    except kind as error:
        raise NotPermitted(str(error)) from error


def functions(module):
    return {
        name for name, found in vars(module).items()
        if inspect.isfunction(found) and found.__module__ == module.__name__ and not name.startswith("_")
    }  # fmt: skip


MODULES = {
    m.__name__: m for m in (services, programs, accounts, accounts_staff, queue, presence, queue_staff, log)
}  # fmt: skip


@pytest.mark.parametrize("module", MODULES)
def test_every_function_of_the_services_has_a_row(module):
    listed = {key.rpartition(".")[2] for key in ROWS if key.rpartition(".")[0] == module}
    assert functions(MODULES[module]) == listed | INNER[module]


def allowed(world, call):
    """Call within a transaction that is undone; tell whether the person was let in."""
    with transaction.atomic():
        try:
            call(world)
        except REFUSED:
            return False
        finally:
            transaction.set_rollback(True)
    return True


@pytest.fixture
def world(robot, roles, monkeypatch):
    monkeypatch.setattr(bus, "ring_stop", lambda slug: True)
    return SimpleNamespace(robot=robot, cast=roles, root=roles["superuser"], user=None)


def of_role(world, role):
    world.user = world.cast[role]
    world.robot.refresh_from_db()
    return world


@pytest.mark.parametrize("name", ROWS)
def test_promise_35_services_by_roles(world, name):
    may, call = ROWS[name]
    assert {role for role in ROLES if allowed(of_role(world, role), call)} == may


# every verb of the admin; each is for robot staff, whatever state the robot is in
@pytest.mark.parametrize("enabled", [True, False])
@pytest.mark.parametrize("verb", verbs.VERBS)
def test_promise_35_admin_verbs_by_roles(world, verb, enabled, monkeypatch):
    sent = []
    monkeypatch.setattr(bus, "send_housekeeping", lambda *a, **k: sent.append(a) or True)
    over(world)
    type(world.robot).objects.update(enabled=enabled, **({"cycle": "locked_out"} if verb == "maintenance" else {}))
    before = type(world.robot).objects.values().get(), Command.objects.count()

    def press(w):
        verbs.VERBS[verb](w.robot, SimpleNamespace(user=w.user, POST={"note": "cleaning", "checked": "yes"}))

    let_in = {role for role in ROLES if allowed(of_role(world, role), press) or sent.clear() or sent}
    assert let_in == ROBOT_STAFF
    assert (type(world.robot).objects.values().get(), Command.objects.count()) == before


def test_every_verb_of_the_file_is_in_the_table():
    assert functions(verbs) - {"staff_only"} == set(verbs.VERBS)
