"""What the recorder writes of a command: nothing that its author or asker keeps private."""

import pytest

from robots.grants import stage_event, start_grant
from robots.kit.clock import SYSTEM
from robots.kit.contract.spec import Spec
from robots.kit.recording.container import COMMANDS
from robots.kit.recording.reading import messages
from robots.models import Command, Grant, Recording
from robots.services import clicks, programs
from robots.states import GrantKind
from tests.waiting import CEILING_S
from workers.recorder.recorder import Recorder, _Running
from workers.recorder.taping import Taping

pytestmark = [pytest.mark.service, pytest.mark.django_db]
TEXT = "g 0\nj 0 25 75 0 80 0"


def recorded(grant: Grant, command: Command, path) -> list[dict[str, object]]:
    """Have a recorder tell of a command; return what is in its file."""
    taping = Taping(path, {}, Spec("none", ()), 0, 10**7, lambda: True)
    one = _Running(Recording(grant=grant), grant, taping, 0)
    Recorder()._tell_command(one, stage_event(command))
    taping.close()
    assert taping.written.wait(CEILING_S)
    return [m.content() for m in messages(path) if m.topic == COMMANDS]


def command_of(grant: Grant, user, kind, args) -> Command:
    now = SYSTEM.now()
    return Command.objects.create(
        robot=grant.robot, grant=grant, epoch=1, kind=kind, args=args, client_seq=1, issued_by=user,
        created_at=now, deadline=now,
    )  # fmt: skip


@pytest.mark.parametrize("which", ["pa10"], indirect=True)
def test_the_text_of_a_program_that_is_not_shared_is_not_recorded(robot, people, tmp_path):
    ada = people["ada"]
    saved = programs.save(robot, ada, "Wave", TEXT, False, SYSTEM.now())
    grant = start_grant(robot, GrantKind.TURN, SYSTEM.now(), holder=ada)
    kind, args = clicks.resolve(robot, ada, "program", {"program": saved.pk})
    assert args["text"] == TEXT
    (told,) = recorded(grant, command_of(grant, ada, kind, args), tmp_path / "a.mcap")
    assert told["args"] == {} and "ada" not in str(told)


def test_numbers_are_recorded_and_who_asked_for_a_job_is_not(robot, people, tmp_path):
    grant = start_grant(robot, GrantKind.JOB, SYSTEM.now())
    command = command_of(grant, people["ada"], "move", {"x": 0.25, "word": "mine"})
    (told,) = recorded(grant, command, tmp_path / "a.mcap")
    assert told["args"] == {"x": 0.25} and "ada" not in str(told)
