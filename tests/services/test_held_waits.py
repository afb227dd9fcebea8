"""A held motion that waited behind another: it moves only if its controls are still held."""

import asyncio
from datetime import UTC, datetime, timedelta

import pytest

from portal.live import consumers, viewing
from portal.live.messages import Command as Asked
from portal.live.messages import Keep, Released
from robots import bus, services
from robots.contract.find import spec_of
from robots.states import GrantKind
from tests.services.owner import made_owner
from workers.safety.deadman import SILENT_S

pytestmark = [pytest.mark.service, pytest.mark.django_db]
SEQ = 3
HELD = [
    ("pa10", "jog_joints", {"S1": 1.0}), ("pa10", "jog_tool", {"x": 1.0}), ("mercury", "jog", {"dx": 1.0, "dy": 0.0}),
    ("irat", "drive", {"forward": 1.0, "turn": 0.0}),
]  # fmt: skip
EACH = pytest.mark.parametrize(("which", "kind", "args"), HELD, indirect=["which"])


def test_these_are_all_held_motions():
    robots = ("mercury", "pa10", "irat", "so101")
    assert {(r, k) for r, k, _ in HELD} == {(r, c.kind) for r in robots for c in spec_of(r).commands if c.held}


@pytest.fixture
def owner(robot, people):
    people["ada"].is_superuser = True  # the iRat's wheels are for staff
    people["ada"].save()
    made = made_owner(robot, people)
    made.done = []
    execute = made.owned.driver.execute

    def executed(kind, args, permit, on_stage):
        made.done.append(kind)
        return execute(kind, args, permit, on_stage)

    made.owned.driver.execute = executed
    return made


def ask(owner, people, kind, args, seq=SEQ):
    return services.issue(owner.owned.robot.slug, people["ada"], kind, args, seq, owner.clock.now()).command


def wait(owner, seconds):
    """Let a motion wait behind another for so long; lease and link stay valid."""
    while seconds > 0:
        owner.clock.go(min(seconds, 1.0))
        owner.lease.renew()
        owner.link.seen()
        seconds -= 1.0


def run(owner, command):
    owner.motion.run_one(command)
    command.refresh_from_db()
    return command


@EACH
@pytest.mark.parametrize("silence", [None, SILENT_S + 0.01, 1.5, 4.4])
def test_a_held_motion_that_waited_unheard_moves_nothing(owner, people, kind, args, silence):
    command = ask(owner, people, kind, args)
    if silence is not None:
        owner.deadman.hear(people["ada"].pk, SEQ, True)
        wait(owner, silence)
    run(owner, command)
    assert owner.done == [], "the driver was asked for nothing"
    assert command.state == "cancelled"
    assert command.reason == ("Nothing was heard from your controls while this motion waited, so it did not begin.")
    assert owner.deadman.ended == ""


@EACH
def test_one_whose_controls_are_held_begins(owner, people, kind, args):
    command = ask(owner, people, kind, args)
    for _ in range(30):
        owner.deadman.hear(people["ada"].pk, SEQ, True)
        wait(owner, 0.08)
    assert run(owner, command).state == "completed"
    assert owner.done == [kind]


@EACH
def test_taps_that_were_released_while_they_waited_move_nothing(owner, people, kind, args):
    """As a stalled line delivers them: presses, keep-alives and releases together."""
    commands = [ask(owner, people, kind, args, seq) for seq in (SEQ, SEQ + 1)]
    for held in (True, True, False):
        for seq in (SEQ, SEQ + 1):
            owner.deadman.hear(people["ada"].pk, seq, held)
    for command in commands:
        assert (run(owner, command).state, command.result["ended"]) == ("completed", "released")
    assert owner.done == []


@EACH
def test_the_press_itself_is_heard_before_its_command_is_written(robot, people, owned, monkeypatch, which, kind, args):
    """So that the owner, who may begin at once, has heard of it."""
    now = datetime.now(UTC)
    services.start_grant(robot, GrantKind.TURN, now, people["ada"], now + timedelta(minutes=5))
    monkeypatch.setattr(viewing, "current_user", lambda scope: people["ada"])
    monkeypatch.setattr(viewing, "sign_in_of", lambda scope, user: None)
    heard = []
    monkeypatch.setattr(
        bus, "_publish", lambda channel, data: heard.append((channel, bus.read_keep_alive(data))) or True
    )
    page = consumers.RobotConsumer()
    page.slug, page.scope, page.me = robot.slug, {}, people["ada"].pk
    page._held = frozenset({kind})
    page._snapshot(True)
    page._ask = lambda message, sent: heard.append(message)
    press = Asked(kind=kind, args=args, seq=SEQ)

    async def typed():
        for message in (press, Keep(seq=SEQ), Released(seq=SEQ), Keep(seq=SEQ)):
            await page.take(message)

    asyncio.run(typed())
    ada, channel = people["ada"].pk, bus.held_channel(robot.slug)
    assert heard == [
        (channel, (ada, SEQ, True)), press, (channel, (ada, SEQ, True)), (channel, (ada, SEQ, False))
    ]  # fmt: skip
