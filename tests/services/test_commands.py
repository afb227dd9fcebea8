"""Commands, stop and lock-out, with their permissions."""

from datetime import timedelta

import pytest
import redis

from robots import bus, services
from robots.kit.clock import SYSTEM
from robots.kit.contract.errors import BadRequest, GrantOver, NotPermitted, OutOfWorkspace, Stopped
from robots.models import Command, Frame, Grant, Lease, Robot
from robots.states import Cycle, GrantEnd, GrantKind
from tests.conftest import CALIBRATION

pytestmark = [pytest.mark.service, pytest.mark.django_db]


def now():
    return SYSTEM.now()


def test_the_holder_of_the_grant_commands(robot, people, grant):
    issued = services.issue(robot.slug, people["ada"], "up", {}, 1)
    assert issued.created
    assert (issued.command.state, issued.command.epoch) == ("queued", 5)


def test_the_same_sequence_number_is_the_same_row(robot, people, grant):
    first = services.issue(robot.slug, people["ada"], "up", {}, 7)
    again = services.issue(robot.slug, people["ada"], "up", {}, 7)
    assert again.command.pk == first.command.pk
    assert not again.created
    assert Command.objects.count() == 1


def test_the_same_command_again_is_answered_though_a_new_one_would_be_refused(robot, people, grant, monkeypatch):
    monkeypatch.setattr("robots.services.commands.PENDING", 1)
    first = services.issue(robot.slug, people["ada"], "up", {}, 7)
    assert services.issue(robot.slug, people["ada"], "up", {}, 7).command.pk == first.command.pk
    services.stop(robot, people["ada"])
    again = services.issue(robot.slug, people["ada"], "up", {}, 7)
    assert (again.command.pk, again.command.state, again.created) == (first.command.pk, "cancelled", False)
    with pytest.raises(Stopped):  # an ended command is not counted as waiting
        services.issue(robot.slug, people["ada"], "up", {}, 8)


@pytest.mark.parametrize("who", ["bob", "eve", "mod", "kim"])
def test_nobody_else_commands(robot, people, grant, who):
    with pytest.raises(GrantOver):
        services.issue(robot.slug, people[who], "up", {}, 1)
    assert Command.objects.count() == 0


def test_without_a_grant_nobody_commands(robot, people, owned):
    with pytest.raises(GrantOver, match="not your turn"):
        services.issue(robot.slug, people["ada"], "up", {}, 1)


def test_an_overdue_grant_commands_nothing(robot, people, grant):
    with pytest.raises(GrantOver, match="over"):
        services.issue(robot.slug, people["ada"], "up", {}, 1, now() + timedelta(minutes=6))


def test_a_robot_without_a_worker_takes_nothing(robot, people, grant, owned):
    owned.expires_at = now() - timedelta(seconds=1)
    owned.save()
    with pytest.raises(services.RobotOffline, match="worker does not answer now"):
        services.issue(robot.slug, people["ada"], "up", {}, 1)


def test_a_stop_latches_and_cancels_what_waits(robot, people, grant):
    command = services.issue(robot.slug, people["ada"], "up", {}, 1).command
    services.stop(robot, people["ada"])
    robot.refresh_from_db()
    command.refresh_from_db()
    assert robot.stop_latched
    assert (command.state, command.reason) == ("cancelled", "the robot was stopped")
    with pytest.raises(Stopped):
        services.issue(robot.slug, people["ada"], "up", {}, 2)


def test_release_wants_a_look(robot, people, grant):
    services.stop(robot, people["ada"])
    with pytest.raises(NotPermitted, match="Look at the newest picture"):
        services.release_stop(robot, people["ada"], checked=False)
    services.release_stop(robot, people["ada"], checked=True)
    robot.refresh_from_db()
    assert not robot.stop_latched
    assert not Command.objects.filter(state="queued").exists(), "release starts nothing"


@pytest.mark.parametrize("who", ["bob", "eve", "mod"])
def test_strangers_neither_stop_nor_release(robot, people, grant, who):
    for verb in (lambda: services.stop(robot, people[who]), lambda: services.release_stop(robot, people[who], True)):
        with pytest.raises(NotPermitted):
            verb()


def test_staff_may_stop(robot, people, grant):
    services.stop(robot, people["kim"])
    robot.refresh_from_db()
    assert robot.stop_latched


@pytest.mark.asvs("2.2.1", "2.2.2")
@pytest.mark.parametrize(
    ("kind", "args", "error"),
    [
        ("fly", {}, BadRequest), ("move", {}, BadRequest), ("move", {"x": "1", "y": 0.4}, BadRequest),
        ("move", {"x": float("nan"), "y": 0.4}, BadRequest), ("move", {"x": 1e308, "y": 0.4}, OutOfWorkspace),
        ("move", {"x": 0.0, "y": 0.1}, OutOfWorkspace), ("move", {"x": 0, "y": 0.4, "z": 1}, BadRequest),
        ("air", {"seconds": 60}, BadRequest), ("click", {"still": 1, "u": 3, "v": 3}, BadRequest),
        ("click", {"still": True, "u": 3, "v": 3}, BadRequest), ("move", [], BadRequest),
    ],
)  # fmt: skip
def test_bad_requests_leave_no_row(robot, people, grant, kind, args, error):
    with pytest.raises(error):
        services.issue(robot.slug, people["ada"], kind, args, 1)
    assert Command.objects.count() == 0


@pytest.mark.parametrize("kind", ["home", "speed", "calibrate", "soft_reset"])
def test_staff_commands_are_not_for_operators(robot, people, grant, kind):
    with pytest.raises(NotPermitted, match="is for staff"):
        services.issue(robot.slug, people["ada"], kind, {}, 1)


def _still(robot, **changes):
    values = {
        "robot": robot, "taken_at": now(), "file": "frames/x.jpg", "width": 192, "height": 165,
        "pose": [0.0, 0.42, 0.0, 0.0], "joints": [1, 1, 0, 0], "calibration": CALIBRATION,
    } | changes  # fmt: skip
    return Frame.objects.create(**values)


def test_a_click_is_mapped_by_the_calibration_of_its_own_picture(robot, people, grant):
    frame = _still(robot)
    robot.calibration = {}
    robot.save()
    command = services.issue(robot.slug, people["ada"], "click", {"still": frame.pk, "u": 150, "v": 40}, 1).command
    assert command.kind == "move"
    a, b, c = CALIBRATION["down"]["matrix"][0]
    assert command.args["x"] == pytest.approx(a * 54.5 + b * -42 + c)


@pytest.mark.asvs("2.2.3")
def test_a_click_in_an_old_picture_is_refused(robot, people, grant):
    frame = _still(robot)
    _still(robot)
    with pytest.raises(BadRequest, match="newest"):
        services.issue(robot.slug, people["ada"], "click", {"still": frame.pk, "u": 1, "v": 1}, 1)


@pytest.mark.parametrize(
    ("later_s", "pose", "refused"),
    [
        (1, [0.0, 0.42, 0.0, 0.01], False), (1, [0.0, 0.47, 0.0, 0.0], True), (1, [0.0, 0.42, 0.0, 0.2], True),
        (-1, [0.0, 0.47, 0.0, 0.0], False), (1, [], False),
    ],
)  # fmt: skip
def test_a_click_is_refused_once_the_robots_pose_is_no_longer_that_of_its_picture(
    robot, people, grant, later_s, pose, refused
):
    frame = _still(robot)
    Lease.objects.filter(robot=robot).update(state={"pose": pose}, state_at=frame.taken_at + timedelta(seconds=later_s))
    if refused:
        with pytest.raises(BadRequest, match="moved since that picture"):
            services.issue(robot.slug, people["ada"], "click", {"still": frame.pk, "u": 150, "v": 40}, 1)
    else:
        assert services.issue(robot.slug, people["ada"], "click", {"still": frame.pk, "u": 150, "v": 40}, 1).created


def test_a_click_off_the_sand_is_refused_with_a_sentence(robot, people, grant):
    frame = _still(robot, pose=[0.23, 0.54, 0.0, 0.0])
    with pytest.raises(OutOfWorkspace, match="off the sand"):
        services.issue(robot.slug, people["ada"], "click", {"still": frame.pk, "u": 190, "v": 2}, 1)


def test_a_picture_of_another_robot_is_unknown(robot, people, grant):
    other = Robot.objects.create(slug="other", name="Other", address="sim:mercury")
    with pytest.raises(BadRequest, match="unknown"):
        services.issue(robot.slug, people["ada"], "click", {"still": _still(other).pk, "u": 1, "v": 1}, 1)


def test_one_open_grant_a_robot_is_a_database_constraint(robot, people, grant):
    with pytest.raises(NotPermitted):
        services.start_grant(robot, GrantKind.STAFF, now(), people["kim"])
    assert Grant.objects.filter(ended_at=None).count() == 1


def test_an_ended_grant_cancels_what_waits_and_ends_once(robot, people, grant):
    command = services.issue(robot.slug, people["ada"], "up", {}, 1).command
    assert services.end_grant(grant, GrantEnd.STAFF, "over", now())
    assert not services.end_grant(grant, GrantEnd.STAFF, "again", now())
    command.refresh_from_db()
    assert command.state == "cancelled"


def test_lock_out_needs_staff_and_a_note_and_only_staff_lift_it(robot, people, grant):
    with pytest.raises(NotPermitted):
        services.lock_out(robot, people["ada"], "mine")
    with pytest.raises(BadRequest, match="note"):
        services.lock_out(robot, people["kim"], "  ")
    services.lock_out(robot, people["kim"], "nozzle is blocked")
    robot.refresh_from_db()
    grant.refresh_from_db()
    assert (robot.cycle, robot.lockout_note, robot.stop_latched) == (Cycle.LOCKED_OUT, "nozzle is blocked", True)
    assert grant.ended_at is not None
    with pytest.raises(NotPermitted):
        services.lift_lock_out(robot, people["ada"])
    services.lift_lock_out(robot, people["kim"])
    robot.refresh_from_db()
    assert robot.cycle == Cycle.HANDOVER, "it is put in order before anybody gets it"


def test_a_maintenance_turn_runs_under_lock_out_only(robot, people, owned):
    with pytest.raises(NotPermitted, match="Lock the robot out first"):
        services.start_maintenance(robot, people["kim"])
    services.lock_out(robot, people["kim"], "service")
    grant = services.start_maintenance(robot, people["kim"])
    assert grant.kind == GrantKind.STAFF
    robot.refresh_from_db()
    services.release_stop(robot, people["kim"], True)
    robot.refresh_from_db()
    assert services.issue(robot.slug, people["kim"], "home", {}, 1).created


@pytest.mark.asvs("2.3.2", "2.4.1")
def test_too_many_waiting_commands_are_refused(robot, people, grant, monkeypatch):
    monkeypatch.setattr("robots.services.commands.PENDING", 3)
    for seq in range(1, 4):
        services.issue(robot.slug, people["ada"], "up", {}, seq)
    with pytest.raises(NotPermitted, match="Too many"):
        services.issue(robot.slug, people["ada"], "up", {}, 4)


def test_a_dead_redis_is_no_error_to_the_person(
    robot, people, grant, django_capture_on_commit_callbacks, monkeypatch, tmp_path
):
    dead = redis.Redis.from_url(f"unix://{tmp_path}/nobody.sock", retry=None)
    monkeypatch.setattr(bus.store, "connection", lambda: dead)
    before = bus.failures["wake"]
    with django_capture_on_commit_callbacks(execute=True):
        assert services.issue(robot.slug, people["ada"], "up", {}, 1).created
    assert bus.failures["wake"] == before + 1


def test_a_release_begins_nothing_that_was_asked_for_before_the_stop(robot, people, grant):
    """A stop that has not got round to all that waits, and a release that is quicker."""
    for number in (1, 2):
        services.issue(robot.slug, people["ada"], "up", {}, number)
    Robot.objects.update(stop_latched=True)  # the stop's first statement; its second is still to come
    services.release_stop(robot, people["ada"], checked=True)
    assert set(Command.objects.values_list("state", flat=True)) == {"cancelled"}
