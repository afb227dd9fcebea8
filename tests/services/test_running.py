"""The owner when its database fails, or cannot store a text, while the robot works."""

import pytest
from django.db import OperationalError, connection

from robots import grants, services
from robots.kit.contract.errors import GrantOver
from robots.models import Command, Grant
from robots.states import GrantKind
from tests.services.owner import made_owner
from workers.commands import rows

pytestmark = [pytest.mark.service, pytest.mark.django_db(transaction=True)]


@pytest.fixture
def owner(robot, people):
    return made_owner(robot, people)


def run(owner, people):
    command = services.issue(owner.owned.robot.slug, people["ada"], "ready", {}, 1, owner.owned.now()).command
    owner.motion.run_one(command)
    command.refresh_from_db()
    return command


@pytest.mark.parametrize("which", ["pa10"], indirect=True)
def test_a_newer_target_that_cannot_be_read_breaks_nothing_off(owner, people, monkeypatch):
    def gone(robot, epoch, lane):
        raise OperationalError("gone")

    def wake():
        owner.wake()
        monkeypatch.setattr(rows, "due", gone)

    owner.owned.driver.on_the_way = wake
    assert run(owner, people).state == "completed"


@pytest.mark.parametrize("which", ["pa10"], indirect=True)
def test_what_breaks_off_in_mid_motion_is_held_and_its_end_is_unknown(owner, people):
    def gone():
        raise OperationalError("gone")

    owner.owned.driver.on_the_way = gone
    command = run(owner, people)
    assert owner.owned.driver.holds == 1
    assert (command.state, "Look at the new picture" in command.reason) == ("unknown", True)
    assert rows.tidy(owner.owned.robot, owner.lease.epoch, owner.owned.now(), "motion") == 0


def follow_while_it_opens(owner, turn, read, monkeypatch):
    """Let the owner follow the grants by `read`; the gate opens for the turn before the answer is used."""

    def read_and_open(robot):
        found = read(robot)
        owner.lane.gate.open_for(turn)
        return found

    with monkeypatch.context() as patch:
        patch.setattr("workers.guard.follow.open_grant", read_and_open)
        owner.follower.follow_grant()
    owner.lane.gate.check()


@pytest.mark.parametrize("which", ["pa10"], indirect=True)
def test_the_end_of_an_earlier_grant_that_is_heard_late_does_not_end_the_next(owner, people, monkeypatch):
    """A turn's first command begins in the very moment in which the end of the handover is read."""
    turn = services.open_grant(owner.owned.robot)
    robot, now = owner.owned.robot, owner.owned.now()
    earlier = Grant.objects.create(robot=robot, kind=GrantKind.HANDOVER, opened_at=now, until=now, ended_at=now)
    owner.lane.gate.open_for(earlier)
    follow_while_it_opens(owner, turn, grants.open_grant, monkeypatch)
    assert run(owner, people).state == "completed"


@pytest.mark.parametrize("which", ["pa10"], indirect=True)
def test_a_grant_that_was_read_before_the_next_is_not_brought_back(owner, monkeypatch):
    turn = services.open_grant(owner.owned.robot)
    earlier = Grant(pk=turn.pk + 1, opened_at=owner.owned.now(), until=owner.owned.now())
    owner.lane.gate.open_for(earlier)
    follow_while_it_opens(owner, turn, lambda robot: earlier, monkeypatch)


@pytest.mark.parametrize("which", ["pa10"], indirect=True)
@pytest.mark.parametrize(("kind", "turn"), [(GrantKind.TURN, True), (GrantKind.JOB, False), (GrantKind.IDLE, False)])
def test_the_end_of_a_turn_is_named_only_where_somebody_had_one(owner, kind, turn):
    over = Grant(pk=9999, kind=kind, opened_at=owner.owned.now(), until=owner.owned.now())
    owner.lane.gate.open_for(over)
    with pytest.raises(GrantOver) as refused:
        owner.lane.gate.check()
    assert ("turn" in str(refused.value)) == turn


@pytest.mark.parametrize("which", ["pa10"], indirect=True)
def test_a_command_is_seen_to_run_only_when_its_grant_is_let_through(owner, people):
    """The thread that watches must not hold it by the grant before."""
    earlier = Grant(pk=9999, opened_at=owner.owned.now(), until=owner.owned.now())
    owner.lane.gate.open_for(earlier)
    owner.grants.revoke(earlier.pk)
    seen = []

    class Watched(type(owner.lane)):
        def __setattr__(self, name, value):
            super().__setattr__(name, value)
            if name == "current" and value is not None:
                seen.append(self.gate.grant_over)

    owner.lane.__class__ = Watched
    assert run(owner, people).state == "completed"
    assert seen == [False]


@pytest.mark.parametrize("which", ["srv1"], indirect=True)
@pytest.mark.skipif(connection.vendor == "postgresql", reason="PostgreSQL stores no half of a letter")
def test_a_program_whose_text_cannot_be_written_is_refused_and_the_owner_goes_on(owner, people):
    for seq in range(1, 5):
        text = {"text": "photograph"}
        command = services.issue(owner.owned.robot.slug, people["ada"], "mission", text, seq, owner.owned.now()).command
        # as an earlier version may have left it, which checked less
        Command.objects.filter(pk=command.pk).update(args={"text": "# \ud800\nphotograph"})
        command.refresh_from_db()
        owner.motion.run_one(command)
        command.refresh_from_db()
        assert (command.state, command.result["code"]) == ("rejected", "bad_request"), command.reason
