"""Each command stores which picture its sender had seen, which one the robot had, and what was clamped."""

from datetime import UTC, datetime, timedelta

import pytest
from django.urls import reverse

from portal.live.actions import act
from portal.live.messages import ROBOT
from portal.live.snapshot import command_info
from queueing.models import Turn
from robots import bus, services
from robots.kit.clock import ms_of
from robots.kit.contract.session import Outcome
from robots.models import Command
from robots.states import CommandState
from tests.services.owner import made_owner
from tests.services.test_stamps import Still
from workers.commands import rows

pytestmark = [pytest.mark.service, pytest.mark.django_db(transaction=True)]


@pytest.fixture
def owner(robot, people, settings, tmp_path):
    settings.MEDIA_ROOT = tmp_path
    return made_owner(robot, people)


def run(owner, people, args=None, **more):
    command = services.issue("mercury", people["ada"], "up", args or {}, 1, owner.owned.now(), **more).command
    owner.motion.run_one(command)
    command.refresh_from_db()
    return command


def test_a_command_stores_the_picture_that_its_sender_saw_and_the_one_that_the_robot_had(owner, people, redis_server):
    owner.pictures.cameras = [Still()]
    now = owner.owned.now()
    bus.watch("mercury", "frames")
    owner.pictures.live_once(owner.owned.driver.latest())
    had = owner.pictures.newest_at
    owner.clock.go(1)
    command = run(owner, people, seen_ms=ms_of(now - timedelta(seconds=3)))
    assert (command.state, command.newest_picture_at) == ("completed", had)
    assert command.seen_picture_at == datetime.fromtimestamp(ms_of(now - timedelta(seconds=3)) / 1000, UTC)
    assert command.picture_lag_s == pytest.approx((had - command.seen_picture_at).total_seconds())
    assert owner.pictures.newest_at > had, "the still at its end"


def test_a_command_whose_sender_saw_nothing_of_a_robot_without_pictures_stores_none(owner, people):
    command = run(owner, people)
    assert (command.state, command.seen_picture_at, command.newest_picture_at) == ("completed", None, None)
    assert (command.picture_lag_s, command.clamping, command.clamped_words) == (None, {}, "")


@pytest.mark.parametrize("seen_ms", [-1, 0, 2**53 - 1, 10**400], ids=str)
def test_a_time_at_which_no_picture_can_have_been_taken_is_not_stored(owner, people, seen_ms):
    assert run(owner, people, seen_ms=seen_ms).seen_picture_at is None


def test_the_page_says_over_its_socket_what_it_showed(owner, people, monkeypatch):
    monkeypatch.setattr("portal.live.actions.current_user", lambda scope: people["ada"])
    monkeypatch.setattr("portal.live.actions.SYSTEM", owner.clock)
    at_ms = ms_of(owner.owned.now()) - 700
    for seq, seen, stored in ((1, f', "seen": {at_ms}', at_ms), (2, "", None)):  # older pages do not say it
        answer = act({}, "mercury", ROBOT.decode(f'{{"t": "command", "kind": "up", "seq": {seq}{seen}}}'))
        assert command_info(Command.objects.get(pk=answer.new_command))["seen_ms"] == stored


@pytest.mark.parametrize(
    ("asked", "sent", "told", "words"),
    [
        ({"speed": 0.5}, {"speed": 0.3}, {"speed": [0.5, 0.3]}, "speed 0.3 instead of 0.5"),
        ({"speed": 0.5, "turn": -1}, {"speed": 0.5, "turn": -0.25}, {"turn": [-1, -0.25]}, "turn -0.25 instead of -1"),
        ({"speed": 0.1 + 0.2}, {"speed": 0.3, "edge": True}, {}, ""),
        ({"speed": 0.5}, {}, {}, ""), ({"on": True}, {"on": False}, {}, ""), ({"text": "a"}, {"text": "b"}, {}, ""),
        ({"speed": 0.5}, {"speed": float("nan")}, {}, ""), ({"speed": 0.5}, {"speed": None}, {}, ""),
    ],
)  # fmt: skip
def test_what_the_driver_sent_instead_of_what_was_asked_is_stored(owner, people, asked, sent, told, words):
    command = services.issue("mercury", people["ada"], "up", {}, 1, owner.owned.now()).command
    command.args = asked
    assert rows.claim(command, owner.lease.epoch, owner.owned.now())
    rows.finish(command, CommandState.COMPLETED, owner.owned.now(), result={"sent": sent} if sent else {})
    assert command.clamping == told
    command.refresh_from_db()
    assert (command.clamping, command.clamped_words) == (told, words)


def test_what_a_driver_clamps_is_stored_with_the_command_that_it_ran(owner, people):
    arm = owner.owned.driver
    arm.execute = lambda kind, args, permit, on_stage: Outcome({"seconds": 0.25}, None)
    command = services.issue("mercury", people["ada"], "air", {"seconds": 0.5}, 1, owner.owned.now()).command
    owner.motion.run_one(command)
    command.refresh_from_db()
    assert (command.state, command.clamping) == ("completed", {"seconds": [0.5, 0.25]})


def test_the_turns_page_and_the_admin_show_it(owner, people, client, robot):
    now = owner.owned.now()
    command = run(owner, people, seen_ms=ms_of(now))
    Command.objects.filter(pk=command.pk).update(
        newest_picture_at=command.seen_picture_at + timedelta(seconds=0.4), clamping={"speed": [0.5, 0.3]}
    )
    turn = Turn.objects.create(
        robot=robot, user=people["ada"], grant=command.grant, started_at=now, base_until=now, until=now, last_seen=now
    )
    page = client.get(turn.get_absolute_url()).content.decode()
    assert "speed 0.3 instead of 0.5" in page
    assert "0.4 s older than the robot" in page
    client.force_login(people["kim"])
    page = client.get(reverse("admin:robots_command_change", args=[command.pk])).content.decode()
    assert "speed 0.3 instead of 0.5" in page
