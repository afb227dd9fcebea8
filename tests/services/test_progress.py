"""The progress of a long command: stored with its row and published, not too often."""

import math

import pytest
from django.db import OperationalError

from portal.live.snapshot import command_info
from robots import bus, services
from robots.kit.contract.session import Progress
from robots.models import Command
from tests.services.owner import made_owner
from workers.commands.progress import EVERY_S, LONGEST, record

pytestmark = pytest.mark.service


@pytest.mark.parametrize(
    ("share", "kept"),
    [(0.5, 0.5), (None, None), (math.nan, None), (math.inf, None), (-3, 0.0), (1e308, 1.0), ("x", None), (1, 1.0)],
)
def test_no_share_is_kept_that_cannot_be_shown(share, kept):
    assert record(Progress("x" * 999, share), 7) == {"text": "x" * LONGEST, "share": kept, "at_ms": 7}


@pytest.mark.django_db(transaction=True)
@pytest.mark.parametrize("which", ["pa10"], indirect=True)
class TestTelling:
    @pytest.fixture
    def run(self, robot, people, monkeypatch):
        owner, told = made_owner(robot, people), []
        monkeypatch.setattr(bus, "publish", lambda slug, event: told.append(event))
        command = services.issue(robot.slug, people["ada"], "ready", {}, 1, owner.owned.now()).command

        def run(steps):
            def execute(kind, args, permit, on_stage):
                permit()
                on_stage("sent")
                on_stage("acknowledged")
                for step in steps:
                    step(owner) if callable(step) else on_stage(step)
                return type(owner.owned.driver).execute(owner.owned.driver, kind, args, permit, on_stage)

            owner.owned.driver.execute = execute
            owner.motion.run_one(command)
            command.refresh_from_db()
            return command, [e.progress for e in told if getattr(e, "progress", None) and e.state == "acknowledged"]

        return run

    def test_it_is_kept_published_and_in_the_snapshot(self, run):
        command, told = run([Progress("step 1 of 2", 0.5)])
        assert (command.state, command.progress["text"], command.progress["share"]) == ("completed", "step 1 of 2", 0.5)
        assert told[0] == command.progress == command_info(command)["progress"]
        assert command.progress["at_ms"] > 0

    def test_what_comes_too_often_is_left_out(self, run):
        steps = [Progress(f"{i}", i / 100) for i in range(100)]
        later = [lambda owner: owner.clock.go(EVERY_S + 0.01), Progress("later", 0.9)]
        command, told = run([*steps, *later])
        assert [p["text"] for p in told] == ["0", "later"]
        assert command.progress["text"] == "later"

    def test_a_database_that_is_away_breaks_nothing_off(self, run, monkeypatch):
        def gone(*_, **__):
            raise OperationalError("gone")

        real = Command.objects.filter

        def away(_):
            monkeypatch.setattr(Command.objects, "filter", gone)

        def back(_):
            monkeypatch.setattr(Command.objects, "filter", real)

        command, _ = run([away, Progress("lost", 0.1), back])
        assert (command.state, command.progress) == ("completed", {})
