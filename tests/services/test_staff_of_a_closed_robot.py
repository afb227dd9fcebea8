"""Requests of staff to a robot that is off, silent, locked out, stopped, in fault or in a turn get a true answer."""

from types import SimpleNamespace

import pytest

from robots import bus, services
from robots.admin import verbs
from robots.kit.clock import SYSTEM
from robots.kit.contract.errors import NotPermitted, RobotError
from robots.models import Command, Grant, Lease, Robot
from robots.services import RobotOffline
from robots.states import Cycle, GrantKind

pytestmark = [pytest.mark.service, pytest.mark.django_db, pytest.mark.usefixtures("owned")]


def off(robot, people):
    services.set_enabled(robot, people["kim"], False)
    Lease.objects.update(expires_at=None)


def silent(robot, people):
    Lease.objects.update(expires_at=None)


def locked_out(robot, people):
    services.lock_out(robot, people["kim"], "hands in the cell")


def stopped(robot, people):
    services.stop(robot, people["kim"])


def in_fault(robot, people):
    Robot.objects.update(cycle=Cycle.FAULT, reason="The cable is pulled.")


def in_a_turn(robot, people):
    services.start_grant(robot, GrantKind.TURN, SYSTEM.now(), people["ada"])
    Robot.objects.update(cycle=Cycle.OPERATING)


SITUATIONS = (off, silent, locked_out, stopped, in_fault, in_a_turn)
OF_A_PERSON = ("place", "your turn", "the queue", "join")


def press(robot, people, verb, **said):
    request = SimpleNamespace(user=people["kim"], POST={"note": "cleaning", **said})
    return verbs.VERBS[verb](Robot.objects.get(pk=robot.pk), request)


@pytest.mark.parametrize("situation", SITUATIONS, ids=lambda one: one.__name__)
@pytest.mark.parametrize("verb", sorted(verbs.VERBS))
def test_no_verb_of_staff_speaks_of_their_place(robot, people, monkeypatch, verb, situation):
    monkeypatch.setattr(bus, "wake_probes", lambda: True)
    situation(robot, people)
    try:
        told = press(robot, people, verb, kind="calibrate", checked="yes")
    except RobotError as error:
        told = str(error)
    assert told.endswith(".")
    if verb != "lock_out":  # it says that other people keep theirs
        assert not any(word in told.lower() for word in OF_A_PERSON), told


@pytest.mark.parametrize("verb", ["procedure", "maintenance"])
@pytest.mark.parametrize(("situation", "words"), [(off, "switched off. Switch it on first"), (silent, "try again in some seconds")])  # fmt: skip
def test_what_needs_a_worker_says_that_there_is_none_and_what_to_do(robot, people, verb, situation, words):
    services.lock_out(robot, people["kim"], "cleaning")
    Robot.objects.update(stop_latched=False)
    situation(robot, people)
    Robot.objects.update(cycle=Cycle.LOCKED_OUT)
    with pytest.raises(RobotOffline, match=words):
        press(robot, people, verb, kind="calibrate")
    assert not (Command.objects.exists() or Grant.objects.filter(ended_at=None).exists())


def test_settings_of_staff_need_a_worker_too(robot, people):
    off(robot, people)
    Robot.objects.update(stop_latched=False)
    with pytest.raises(RobotOffline, match="Switch it on first"):
        services.configure(robot, people["kim"], "speed", {"speed": 0.3})


@pytest.mark.parametrize(
    ("situation", "verb", "words"),
    [
        (in_fault, "test", "has a fault: The cable is pulled."), (stopped, "test", "it is stopped, so no picture"),
        (in_a_turn, "test", "it is in use, so no picture"), (silent, "test", "worker does not answer"),
        (in_a_turn, "enable", "is on already"), (in_a_turn, "release", "is not stopped"),
        (off, "stop", "stays stopped when it is switched on"), (off, "enable", "is stopped: look at the newest picture"),
        (in_a_turn, "lift", "not locked out"), (in_a_turn, "procedure", "lock it out first"),
        (stopped, "procedure", "Look at the picture, then release the stop"),
        (locked_out, "lift", "is stopped: look at the newest picture"),
    ],
)  # fmt: skip
def test_each_says_what_is_so_and_what_to_do(robot, people, situation, verb, words):
    situation(robot, people)
    try:
        told = press(robot, people, verb, kind="calibrate")
    except NotPermitted as error:
        told = str(error)
    assert words in told


@pytest.mark.parametrize("verb", ["enable", "release", "lift"])
def test_the_second_of_two_presses_is_no_error(robot, people, verb):
    {"enable": off, "release": stopped, "lift": locked_out}[verb](robot, people)
    press(robot, people, verb, checked="yes")
    assert press(robot, people, verb, checked="yes") in (
        "The robot is on already.", "The robot is not stopped.", "The robot is not locked out.",
    )  # fmt: skip


def test_an_old_page_s_release_cancels_nothing_of_whoever_drives(robot, people):
    in_a_turn(robot, people)
    command = services.issue(robot.slug, people["ada"], "up", {}, 1).command
    press(robot, people, "release", checked="yes")
    command.refresh_from_db()
    assert command.state == "queued"
