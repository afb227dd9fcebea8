"""Who may do what: every public function of the services, and every verb of the admin, by every role.

A function that is in no table fails the test, so nobody adds a verb without saying who may use it.
"""

import inspect
import pkgutil
from contextlib import suppress
from functools import partial
from importlib import import_module
from types import SimpleNamespace

import pytest
from allauth.account.models import EmailAddress
from django.core.exceptions import PermissionDenied
from django.db import transaction

from accounts import services as accounts
from accounts.models import Choice, Clearance, PushSubscription, Question
from accounts.push import PushRefused, subscribe
from accounts.turn_mails import MailRefused
from operatorlog import services as log
from operatorlog.finds import NextRound, Report, begin_first
from operatorlog.models import Entry, Find, SurveyQuestion, Visibility
from queueing import admin as queue_admin
from queueing import services as queue
from queueing.errors import QueueError
from queueing.models import Job, Turn
from queueing.services import Asker, ask
from robots import bus, services
from robots.admin import verbs
from robots.kit.clock import SYSTEM
from robots.kit.contract.errors import BadRequest, NotPermitted
from robots.kit.contract.spec import ANYONE, CommandKind
from robots.models import Command, Frame, Incident, Program, Recording
from robots.models.recordings import OfTheDay
from robots.services import RobotOffline
from robots.states import GrantEnd
from tests.services.conftest import ROLES

pytestmark = pytest.mark.django_db
REFUSED = (NotPermitted, QueueError, log.LogError, accounts.NotNow, PushRefused, MailRefused, PermissionDenied)

ANYBODY = frozenset(ROLES)
SIGNED_IN = ANYBODY - {"anonymous"}
OPERATOR, CLEARED = frozenset({"operator"}), frozenset({"cleared", "operator"})
ROBOT_STAFF = frozenset({"robot_staff", "superuser"})
MODERATORS = frozenset({"log_moderator", "superuser"})
ADMINS = frozenset({"superuser"})


def turn(w):
    return Turn.objects.get(ended_at=None)


def over(w):
    one = turn(w)
    queue.end_turn(one, GrantEnd.STAFF, "over", SYSTEM.now())
    one.refresh_from_db()
    return one


def entry(w):
    one = over(w)
    return Entry.objects.create(turn=one, author=one.user, robot=w.robot, text="x", written_at=SYSTEM.now())


def hidden(w):
    one = entry(w)
    log.moderate(one, w.root, Visibility.HIDDEN, "rude", SYSTEM.now())
    return one


def decision(w):
    """The person's own, as if they had lost the right to moderate since."""
    made = log.moderate(entry(w), w.root, Visibility.FEATURED, "", SYSTEM.now())
    made.by_id = w.user.pk
    made.save()
    return made


def find(w):
    one = over(w)
    return log.report(one, one.user, Report("x", None, 0.1, 0.4), SYSTEM.now())


def locked(w):
    services.lock_out(w.robot, w.root, "cleaning")
    w.robot.refresh_from_db()
    return w.robot


def maintained(w):
    services.start_maintenance(locked(w), w.root)
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


def asker(w):
    return Asker(user=w.user if w.user.is_authenticated else None)


def job(w, state="waiting"):
    one = ask(w.robot, Asker(user=w.cast["operator"]), "down", {}, SYSTEM.now())
    Job.objects.filter(pk=one.pk).update(state=state)
    one.refresh_from_db()
    return one


def told(w, name):
    return subscribe(w.cast[name], "https://push.example.org/", ("k", "s"), "", SYSTEM.now()).pk


def one_question():
    return SurveyQuestion.objects.create(prompt="Q").pk


def refused():
    raise NotPermitted


def signed(w):
    """The pages ask for these about people who have signed in, and never about others."""
    return None if w.user.is_authenticated else refused()


def confirmed(w):
    if w.user.pk:
        EmailAddress.objects.create(user=w.user, email=w.user.email, verified=True, primary=True)
    return w.user


def an_attempt(w, user):
    if not Question.objects.exists():
        right = Question.objects.create(robot=w.robot, text="?")
        Choice.objects.create(question=right, text="!", correct=True)
    accounts.mark_read(user, w.robot, SYSTEM.now())
    return accounts.begin(user, w.robot, SYSTEM.now())


# function: (who may, the call)
ROWS = {
    "robots.resolve": (ANYBODY, lambda do, w: do(w.robot, w.user, "down", {})),
    "robots.with_program": (ANYBODY, lambda do, w: do(w.robot, w.user, "down", {})),
    "robots.grant_of": (OPERATOR, lambda do, w: do(w.robot, w.user, SYSTEM.now())),
    "robots.issue": (OPERATOR, lambda do, w: do(w.robot.slug, w.user, "down", {}, 7)),
    "robots.may_stop": (ANYBODY, lambda do, w: do(w.robot, w.user)),
    "robots.stop": (OPERATOR | ROBOT_STAFF, lambda do, w: do(w.robot, w.user)),
    "robots.release_stop": (OPERATOR | ROBOT_STAFF, lambda do, w: do(w.robot, w.user, True)),
    "robots.lock_out": (ROBOT_STAFF, lambda do, w: do(w.robot, w.user, "cleaning")),
    "robots.lift_lock_out": (ROBOT_STAFF, lambda do, w: do(locked(w), w.user)),
    "robots.start_maintenance": (ROBOT_STAFF, lambda do, w: do(locked(w), w.user)),
    "robots.end_maintenance": (ROBOT_STAFF, lambda do, w: do(maintained(w), w.user)),
    "robots.staff_command": (
        ROBOT_STAFF, lambda do, w: (over(w), do(w.robot, w.user, "soft_reset")),
    ),
    "robots.configure": (ROBOT_STAFF, lambda do, w: do(w.robot, w.user, "speed", {"speed": 0.3})),
    "robots.set_enabled": (ROBOT_STAFF, lambda do, w: do(w.robot, w.user, False)),
    "robots.add_twin": (ROBOT_STAFF, lambda do, w: do(w.robot, w.user)),
    "robots.ask": (ROBOT_STAFF, lambda do, w: do(w.robot, w.user, SYSTEM.now())),
    "robots.close_incident": (
        ROBOT_STAFF,
        lambda do, w: do(Incident.objects.create(robot=w.robot, at=SYSTEM.now()), w.user),
    ),
    "robots.take_down": (ROBOT_STAFF, lambda do, w: do(Frame.objects.create(robot=w.robot, file="frames/x.jpg", width=1, height=1, taken_at=SYSTEM.now()), w.user)),
    "robots.remove_recording": (ROBOT_STAFF, lambda do, w: do(Recording.objects.create(robot=w.robot, grant=turn(w).grant, began_at=SYSTEM.now()), w.user)),
    "robots.choose_of_the_day": (ROBOT_STAFF, lambda do, w: do(Recording.objects.create(robot=w.robot, grant=turn(w).grant, began_at=SYSTEM.now()), OfTheDay.NEVER, w.user)),
    "robots.visible": (ANYBODY, lambda do, w: list(do(w.robot, w.user))),
    "robots.visible_program": (OPERATOR, lambda do, w: refuse(BadRequest, do, w.robot, w.user, program(w).pk)),
    "robots.save": (
        SIGNED_IN, lambda do, w: do(w.robot, w.user, "p", "down", False, SYSTEM.now()),
    ),
    "robots.delete": (OPERATOR, lambda do, w: do(w.robot, w.user, program(w).pk)),
    "robots.approve": (
        ADMINS, lambda do, w: do(program(w, shared=True), w.user, True),
    ),
    "accounts.preview_job": (CLEARED | ROBOT_STAFF, lambda do, w: do(w.robot, w.user, "down", {}, ())),
    "accounts.cleared": (CLEARED, lambda do, w: do(w.user, w.robot) or refused()),
    "accounts.may_do_more": (ADMINS, lambda do, w: do(w.root, w.user) and refused()),
    "accounts.drives_more": (CLEARED | ADMINS, lambda do, w: signed(w) or (do(w.cast["cleared"], w.user) and refused())),
    "accounts.has_read": (SIGNED_IN, lambda do, w: (w.user.pk and do(w.user, w.robot)) or signed(w)),
    "accounts.mark_read": (SIGNED_IN, lambda do, w: do(w.user, w.robot, SYSTEM.now())),
    "accounts.pause_left": (SIGNED_IN, lambda do, w: signed(w) or do(w.user, w.robot, SYSTEM.now())),
    "accounts.withdrawn_clearance": (SIGNED_IN, lambda do, w: signed(w) or do(w.user, w.robot)),
    "accounts.begin": (SIGNED_IN, lambda do, w: an_attempt(w, w.user)),
    "accounts.grade": (OPERATOR, lambda do, w: do(an_attempt(w, w.cast["operator"]), w.user, dict.fromkeys(Question.objects.values_list("pk", flat=True), 0), SYSTEM.now())),
    "accounts.withdraw": (ADMINS, lambda do, w: do(held(w), w.user, "x", SYSTEM.now())),
    "accounts.lift": (ADMINS, lambda do, w: do(held(w), w.user, "x", SYSTEM.now())),
    "accounts.subscriptions_of": (ANYBODY, lambda do, w: list(do(w.user))),
    "accounts.subscribe": (SIGNED_IN, lambda do, w: do(w.user, "https://push.example.org/", ("k", "s"), "", SYSTEM.now())),
    "accounts.unsubscribe": (OPERATOR, lambda do, w: do(w.user, told(w, "operator")) or refused()),
    "accounts.unsubscribe_all": (OPERATOR, lambda do, w: (told(w, "operator"), do(w.user), PushSubscription.objects.exists() and refused())),
    "accounts.choose_mail": (SIGNED_IN, lambda do, w: do(confirmed(w), True)),
    "queueing.open_ticket": (ANYBODY, lambda do, w: do(w.robot, w.user)),
    "queueing.turn_of": (ANYBODY, lambda do, w: do(w.robot, w.user)),
    "queueing.change_place": (CLEARED, lambda do, w: do("join", w.robot, w.user, SYSTEM.now(), queue.Page())),
    "queueing.join": (CLEARED, lambda do, w: do(w.robot, w.user, SYSTEM.now())),
    "queueing.accept": (CLEARED, lambda do, w: do(offered(w), w.user, SYSTEM.now())),
    "queueing.note_presence": (ANYBODY, lambda do, w: do(w.robot, w.user, SYSTEM.now())),
    "queueing.leave": (ANYBODY, lambda do, w: do(w.robot, w.user, SYSTEM.now())),
    "queueing.ask": (CLEARED, lambda do, w: do(w.robot, asker(w), "down", {}, SYSTEM.now())),
    "queueing.cancel": (OPERATOR | ROBOT_STAFF, lambda do, w: do(job(w), asker(w), SYSTEM.now())),
    "queueing.resume": (ROBOT_STAFF, lambda do, w: do(w.robot, w.user, SYSTEM.now())),
    "queueing.remove_by_staff": (ROBOT_STAFF, lambda do, w: do(turn(w).ticket, w.user, SYSTEM.now())),
    "queueing.end_by_staff": (ROBOT_STAFF, lambda do, w: do(turn(w), w.user, SYSTEM.now())),
    "operatorlog.hand_in": (OPERATOR, lambda do, w: do(over(w), w.user, "x", None, {}, SYSTEM.now())),
    "operatorlog.write": (OPERATOR, lambda do, w: do(over(w), w.user, "x", None, SYSTEM.now())),
    "accounts.is_seen": (ANYBODY, lambda do, w: do(w.user, w.robot.slug) or refused()),
    "operatorlog.entries_for": (ANYBODY, lambda do, w: do(w.user)),
    "operatorlog.may_edit": (ANYBODY, lambda do, w: do(entry(w), w.user, SYSTEM.now())),
    "operatorlog.may_see_hidden": (OPERATOR | MODERATORS | ROBOT_STAFF | frozenset({"viewer"}), lambda do, w: do(entry(w), w.user) or refused()),
    "operatorlog.may_see_picture": (OPERATOR | MODERATORS | ROBOT_STAFF | frozenset({"viewer"}), lambda do, w: do(entry(w), "x.jpg", w.user) or refused()),
    "operatorlog.edit": (OPERATOR, lambda do, w: do(entry(w), w.user, "y", None, SYSTEM.now())),
    "operatorlog.moderate": (
        MODERATORS, lambda do, w: do(entry(w), w.user, Visibility.FEATURED, "", SYSTEM.now()),
    ),
    "operatorlog.undo": (MODERATORS, lambda do, w: do(decision(w), w.user, SYSTEM.now()) or refused()),
    "operatorlog.appeal": (OPERATOR, lambda do, w: do(hidden(w), w.user, "please", SYSTEM.now())),
    "operatorlog.may_appeal": (OPERATOR, lambda do, w: do(hidden(w), w.user) or refused()),
    "operatorlog.answer_survey_of_job": (
        OPERATOR, lambda do, w: do(job(w, "done"), asker(w), {one_question(): "4"}, SYSTEM.now()),
    ),
    "operatorlog.report": (OPERATOR, lambda do, w: do(over(w), w.user, Report("x", None, 0.1, 0.4), SYSTEM.now())),
    "operatorlog.decide": (ADMINS, lambda do, w: do(find(w), w.user, Find.State.DECLINED, None, SYSTEM.now())),
    "operatorlog.bury_again": (
        ADMINS, lambda do, w: (
            (over(w) and do(begin_first(w.robot, SYSTEM.now()), w.user, NextRound("Who?"), SYSTEM.now())) or refused()
        ),
    ),
    "operatorlog.answer_survey": (OPERATOR, lambda do, w: do(over(w), w.user, {}, SYSTEM.now())),
}  # fmt: skip
# what is asked about the very person of a request and touches nobody else's rows, and the checks themselves
OWN = {
    "accounts.keep_language", "accounts.unsubscribe_signed_out", "accounts.mail_choice", "accounts.mail_address", "accounts.count_mail", "accounts.uncount_mail",
    "portal.fresh_token", "portal.spend_token", "portal.name_of", "queueing.account_of", "queueing.may_ask",
    "queueing.kinds_for", "queueing.may_cancel", "queueing.announce", "queueing.note_disconnection", "queueing.dismiss", "queueing.note_waiting",
    "queueing.standings", "queueing.stay", "queueing.note_act", "queueing.last_turn", "queueing.own_jobs", "queueing.job_of_form", "queueing.mark_seen", "queueing.unseen_jobs", "queueing.may_answer",
    "queueing.note_answered", "robots.put", "robots.held_by", "robots.issue_under",
    "robots.need_staff", "robots.need_level", "robots.reaches",
    "operatorlog.begin_first",  # who notes that the first round begins; its callers ask for permission
}  # fmt: skip


def refuse(kind, function, *arguments):
    try:
        return function(*arguments)
    except kind as error:
        raise NotPermitted(str(error)) from error


def functions(module):
    return {
        name: found for name, found in vars(module).items()
        if inspect.isfunction(found) and found.__module__ == module.__name__ and not name.startswith("_")
    }  # fmt: skip


def of_a_person():
    """Every public function of the apps that is told who asks, wherever it stands."""
    found = {}
    for room in (
        "robots",
        "robots.services",
        "accounts",
        "queueing",
        "queueing.jobs",
        "operatorlog",
        "portal.web.classic",
    ):
        for module in pkgutil.iter_modules(import_module(room).__path__):
            if module.ispkg or module.name in ("admin", "views"):
                continue
            for name, function in functions(import_module(f"{room}.{module.name}")).items():
                if {"user", "asker"} & set(inspect.signature(function).parameters):
                    found[f"{room.partition('.')[0]}.{name}"] = function
    return found


FOUND = of_a_person()


@pytest.mark.asvs("8.2.2", "8.3.1")
def test_every_function_that_is_told_who_asks_has_a_row():
    assert set(FOUND) == set(ROWS) | OWN


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
    monkeypatch.setattr(bus, "send_stop", lambda slug, grant=0: True)
    monkeypatch.setattr(bus, "wake_probes", lambda: True)
    asked_for = CommandKind("down", "Down", asked_by=frozenset({ANYONE}))
    monkeypatch.setattr("queueing.jobs.asking.job_kinds", lambda robot: (asked_for,))
    return SimpleNamespace(robot=robot, cast=roles, root=roles["superuser"], user=None)


def of_role(world, role):
    world.user = world.cast[role]
    world.robot.refresh_from_db()
    return world


@pytest.mark.asvs("8.2.2", "8.3.1")
def test_promise_35_services_by_roles(world):
    let_in = {
        name: {role for role in ROLES if allowed(of_role(world, role), partial(call, FOUND[name]))}
        for name, (_, call) in ROWS.items()
    }
    assert let_in == {name: may for name, (may, _) in ROWS.items()}


# every verb of the admin; each is for robot staff, whatever state the robot is in
@pytest.mark.asvs("8.2.1", "8.3.1")
@pytest.mark.parametrize("enabled", [True, False])
@pytest.mark.parametrize("verb", verbs.VERBS)
def test_promise_35_admin_verbs_by_roles(world, verb, enabled, monkeypatch):
    sent = []
    monkeypatch.setattr(bus, "wake_probes", lambda: sent.append("probe") or True)
    over(world)
    type(world.robot).objects.update(
        enabled=enabled, **({"cycle": "locked_out"} if verb in ("maintenance", "lift") else {})
    )
    before = type(world.robot).objects.values().get(), Command.objects.count()

    def press(w):
        with suppress(RobotOffline):  # let in, and told that the robot is off
            kind = "speed" if verb == "setting" else "soft_reset"
            form = {"note": "cleaning", "checked": "yes", "kind": kind, "speed": "0.3"}
            verbs.VERBS[verb](w.robot, SimpleNamespace(user=w.user, POST=form))

    let_in = {role for role in ROLES if allowed(of_role(world, role), press) or sent.clear() or sent}
    assert let_in == ROBOT_STAFF
    assert (type(world.robot).objects.values().get(), Command.objects.count()) == before


def test_every_verb_of_the_file_is_in_the_table():
    of_queues = set(functions(queue_admin))
    assert of_queues == {"resume_jobs"}
    assert set(functions(verbs)) - {"staff_only", "add", "after_adding", "settings_by_staff"} | of_queues == set(
        verbs.VERBS
    )
