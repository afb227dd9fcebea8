"""A held motion that waited behind another: it moves only if its controls are still held."""

import asyncio
from datetime import timedelta
from math import inf

import pytest
from asgiref.sync import async_to_sync, sync_to_async

from portal.live import actions, controls, robot_socket, snapshot_sender
from portal.live.loop import LoopState
from portal.live.messages import Accept, Keep, Released
from portal.live.messages import Command as Asked
from portal.live.people import Role
from queueing import services as queue
from robots import bus, services
from robots.grants import open_grant
from robots.kit.clock import SYSTEM
from robots.kit.contract.find import spec_of
from robots.models import Command
from robots.states import GrantEnd, GrantKind
from tests.services.owner import made_owner
from workers.guard.deadman import SILENT_S

pytestmark = [pytest.mark.service, pytest.mark.django_db]
SEQ = 3
HELD = [
    ("pa10", "jog_joints", {"S1": 1.0}), ("pa10", "jog_tool", {"x": 1.0}),
    ("pa10", "follow", dict.fromkeys(("dx", "dy", "dz", "rx", "ry", "rz"), 0.0)), ("mercury", "jog", {"dx": 1.0, "dy": 0.0}),
    ("irat", "drive", {"forward": 1.0, "turn": 0.0}),
]  # fmt: skip
EACH = pytest.mark.parametrize(("which", "kind", "args"), HELD, indirect=["which"])
# nobody drives the iRat in turns
TURNS = pytest.mark.parametrize(("which", "kind", "args"), HELD[:4], indirect=["which"])


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
        owner.link.note_answer()
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
        owner.deadman.hear(command.pk, True)
        wait(owner, silence)
    run(owner, command)
    assert owner.done == [], "the driver was asked for nothing"
    assert command.state == "cancelled"
    assert command.reason == ("Nothing was heard from your controls while this motion waited, so it did not begin.")
    assert owner.deadman.end_reason == ""


@EACH
def test_one_whose_controls_are_held_begins(owner, people, kind, args):
    command = ask(owner, people, kind, args)
    for _ in range(30):
        owner.deadman.hear(command.pk, True)
        wait(owner, 0.08)
    assert run(owner, command).state == "completed"
    assert owner.done == [kind]


@EACH
def test_taps_that_were_released_while_they_waited_move_nothing(owner, people, kind, args):
    """As a stalled line delivers them: presses, keep-alives and releases together."""
    commands = [ask(owner, people, kind, args, seq) for seq in (SEQ, SEQ + 1)]
    for held in (True, True, False):
        for command in commands:
            owner.deadman.hear(command.pk, held)
    for command in commands:
        assert (run(owner, command).state, command.result["ended"]) == ("completed", "released")
    assert owner.done == []


class Line:
    """What a page's socket passes on, and a database that answers when the test says so."""

    def __init__(self, robot, people, monkeypatch, kind):
        now = SYSTEM.now()
        services.start_grant(robot, GrantKind.TURN, now, people["ada"], now + timedelta(minutes=5))
        monkeypatch.setattr(snapshot_sender, "current_user", lambda scope: people["ada"])
        monkeypatch.setattr(
            bus.publishing, "send", lambda _, data: self.heard.append(tuple(bus.read_keep_alive(data)[:2])) or True
        )
        self.heard, self.page, self.said, self.tasks = [], robot_socket.RobotSocket(), [], []
        self.page.scope = {"url_route": {"kwargs": {"slug": robot.slug}}}
        self.page.shared = LoopState()
        self.page.prepare()
        self.controls = self.page.controls
        self.controls.kinds = frozenset({kind})
        _, self.page.role, _ = self.page.snapshots.read(True)
        self.page.begin = lambda task: task.close()
        self.page.requests.answer = self.answer

    async def answer(self, message, answer):
        self.said.append(answer)

    async def type(self, *messages):
        for message in messages:
            await self.page.take(message)


@pytest.fixture
def line(robot, people, owned, monkeypatch, which, kind, args):
    people["ada"].is_superuser = True  # see `owner`
    people["ada"].save()
    made = Line(robot, people, monkeypatch, kind)
    made.press = Asked(kind=kind, args=args, seq=SEQ)
    return made


@EACH
@pytest.mark.parametrize(("then", "heard"), [
    ([], [(70, True)]), ([Keep(seq=SEQ)], [(70, True)]), ([Keep(seq=SEQ + 1)], [(70, True)]),
    ([Released(seq=SEQ)], [(70, False)]), ([Released(seq=SEQ), Keep(seq=SEQ)], [(70, False)]),
])  # fmt: skip
def test_controls_are_heard_as_soon_as_their_command_is_written(line, then, heard):
    async def typed():
        await line.type(line.press, *then)
        assert line.heard == [], "nobody knows yet which command they hold"
        await line.controls.assign(line.press, 70)

    asyncio.run(typed())
    assert line.heard == heard


@EACH
def test_from_then_on_each_keep_alive_names_the_command(line):
    async def typed():
        await line.type(line.press)
        await line.controls.assign(line.press, 70)
        await line.type(Keep(seq=SEQ), Released(seq=SEQ), Keep(seq=SEQ))

    asyncio.run(typed())
    assert line.heard == [(70, True), (70, True), (70, False)]


@EACH
def test_controls_that_fell_silent_before_the_command_was_written_do_not_count(line):
    async def typed():
        await line.type(line.press)
        line.controls._heard_at -= controls.HEARD_S + 0.01
        await line.controls.assign(line.press, 70)

    asyncio.run(typed())
    assert line.heard == []


@EACH
def test_a_press_counts_whatever_the_last_snapshot_said(line):
    """It may have been read before the turn began, or not at all, because the database was away."""
    line.page.role = Role(line.page.role.person)

    async def typed():
        await line.type(line.press, Keep(seq=SEQ))
        await line.controls.assign(line.press, 70)
        await line.type(Keep(seq=SEQ), Released(seq=SEQ))

    asyncio.run(typed())
    assert line.heard == [(70, True), (70, True), (70, False)]


@TURNS
def test_a_press_that_comes_before_the_turn_was_accepted_keeps_its_motion(line, robot, people, monkeypatch):
    """All that a page sends at once; a keep-alive before its press is of nothing."""
    services.end_grant(open_grant(robot), GrantEnd.STAFF, "over", SYSTEM.now())
    queue.join(robot, people["ada"], SYSTEM.now())
    queue.tick(SYSTEM.now())
    _, line.page.role, _ = line.page.snapshots.read(True)
    assert not line.page.role.grant
    monkeypatch.setattr(controls, "HEARD_S", inf)  # the database takes as long as it takes
    monkeypatch.setattr(actions, "current_user", lambda scope: people["ada"])
    monkeypatch.setattr(line.page, "orm", lambda function, *args: sync_to_async(function)(*args))
    monkeypatch.setattr(line.page, "begin", lambda task: line.tasks.append(asyncio.create_task(task)))

    async def typed():
        await line.type(Accept(), Keep(seq=SEQ), line.press, Keep(seq=SEQ))
        while len(line.said) < 2:
            await asyncio.sleep(0.001)
        await line.type(Keep(seq=SEQ), Released(seq=SEQ), Keep(seq=SEQ))
        for task in line.tasks:
            task.cancel()

    async_to_sync(typed)()
    assert [answer.ok for answer in line.said] == [True, True], line.said
    written = Command.objects.get(kind=line.press.kind).pk
    assert line.heard == [(written, True), (written, True), (written, False)]


@EACH
def test_a_page_whose_press_wrote_no_command_keeps_no_motion_of_another(line, robot, people, kind, args):
    """Refused, answered with what another page wrote under the same number, or not even taken."""
    mine, again = (services.issue(robot.slug, people["ada"], kind, args, SEQ) for _ in range(2))
    assert (mine.created, again.created) == (True, False)
    line.heard.clear()

    async def typed():
        await line.type(line.press, Keep(seq=SEQ))
        await line.controls.assign(line.press, 0)
        await line.type(Keep(seq=SEQ), Released(seq=SEQ))
        while not line.page.requests._queue.full():
            line.page.requests._queue.put_nowait((line.press, False))
        await line.type(line.press, Keep(seq=SEQ))

    asyncio.run(typed())
    assert line.heard == []
    assert line.said[-1].code == "busy" and not line.controls._pressed


@pytest.mark.parametrize(
    "data",
    [
        b"7 3 1",
        b"7 3",
        b"held 7",
        b"held 7 2",
        b"held -7 1",
        b"",
        b"held 7 1 1",
        b"held 7 1 {}",
        b'held 7 1 {"a": "b"}',
        b'held 7 1 {"a": true}',
        b"held 7 1 [1]",
        b'held 7 1 {"a"',
        b"held 7 1 " + b'{"a":1}' * 999,
    ],
)
def test_a_keep_alive_of_an_earlier_version_is_none(data):
    with pytest.raises(ValueError, match="not a keep-alive"):
        bus.read_keep_alive(data)
    assert bus.read_keep_alive(b"held 7 1") == (7, True, {})
