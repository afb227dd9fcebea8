"""The robot's socket: pictures, states and events out; commands, stop and presence in.

A stop and the keep-alives of a held motion do not wait for the database: they are sent to the bus at once, if the role
in the last snapshot allows it. Everything else is carried out in order.
"""

import asyncio
import contextlib
import json
import logging
from typing import Any
from urllib.parse import parse_qs

from django.db import Error

from accounts.services import cleared
from portal.edge.direct import connection_of
from portal.live.access import Access, AccessRefused
from portal.live.actions import SIGN_IN, Answer, act
from portal.live.controls import HeldControls
from portal.live.messages import (
    ROBOT,
    Cheer,
    Command,
    Keep,
    NotUnderstood,
    Ping,
    Plan,
    Released,
    RobotMessage,
    Stop,
    Watch,
)
from portal.live.people import Role, current_user
from portal.live.pieces import JoinedText
from portal.live.presence import Presence
from portal.live.previews import Question
from portal.live.sessions import NOT_STAFF, UNCLEARED, Ending
from portal.live.snapshot_sender import NOT_FOUND, SnapshotSender
from portal.live.socket import Socket
from portal.live.threads import URGENT
from portal.live.viewer import STRANGER, Cameras, Viewer, Wish
from portal.live.writer import Writer
from portal.stores import down_text
from robots import bus
from robots.kit.clock import SYSTEM
from robots.kit.contract.command_packet import HOLD, PING, TYPE, CommandLayout
from robots.kit.description import coding, views
from robots.models import Robot

log = logging.getLogger(__name__)
WAITING = 64
PACKED = (TYPE, HOLD, PING)  # the first byte of a command, or of a word about one, in bytes
PING_BYTES = 3
UNKNOWN_COMMANDS = "The robot's commands could not be read; reload the page."
OUR_FAULT = "The portal failed at this request. Staff can find the reason in the log."


class RobotSocket(Socket):
    """One viewer of one robot; the holder of the grant may also command it."""

    wire = ROBOT
    slug: str
    viewer: Viewer
    layout: CommandLayout | None = None  # of commands in bytes

    def __init__(self, *args: Any, access: type[Access] = Access, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self._make_access = access
        self._leave = contextlib.ExitStack()
        self._watching = False

    def prepare(self) -> None:
        """Make the parts of the socket."""
        self.slug, self.hub = self.scope["url_route"]["kwargs"]["slug"], self.shared.hub
        self.access = self._make_access(self.slug, self.scope, self.hub)
        self.protocol, self.pool = self.access.protocol, self.access.pool
        self.viewer = Viewer(self.slug, connection_of(self.scope))
        self.outdated = asyncio.Event()
        self.writer = Writer(self.viewer, self.send, self.outdated, self.hub)
        self.snapshots = SnapshotSender(self, self.viewer, self.access, self.writer, self.outdated)
        self.presence = Presence(self, self.slug, self.access)
        self.controls = HeldControls(self.slug)
        self.requests = Requests(self, self.viewer, self.controls, self.snapshots)
        self.joined = JoinedText()
        self.plans = PlanSender(self, self.slug, self.writer)

    async def open(self) -> None:
        """Check the access, then watch: the snapshot first, then everything that comes, as far as it is wanted."""
        cameras = None
        try:
            await self.access.admit()
            try:
                if not (self.stranger and self.hub.viewers(self.slug)):  # else it needs nothing of the database
                    self.role, self.controls.kinds, cameras, self.layout = await self.orm(self.look)
            except Error as error:
                await self.snapshots.report_store_down(error)
            self.access.enter(self.role.person, self.stranger, self._leave)
        except AccessRefused as refused:
            await self.close(refused.code, str(refused))
            return
        except Robot.DoesNotExist:
            await self.close(NOT_FOUND)
            return
        await self._watch(cameras)
        if self.role.person:
            self.presence.note()

    def look(self) -> tuple[Role, frozenset[str], Cameras, CommandLayout | None]:
        """Return the role, the kinds of held motions, the robot's cameras and commands; runs in a thread.

        Raises Robot.DoesNotExist.
        """
        user = current_user(self.scope)
        role = Role(user.pk or 0, not user.is_authenticated)
        robot = Robot.objects.get(slug=self.slug)
        try:
            held, layout = frozenset(c.kind for c in robot.spec().commands if c.held), CommandLayout.of(robot.spec())
            described = robot.description()
            return role, held, Cameras(len(views(described)), coding(described)), layout
        except (LookupError, ImportError, OSError):  # its package is not installed
            return role, frozenset(), Cameras(), None

    async def _watch(self, cameras: Cameras | None) -> None:
        """Start to watch. `cameras`: those of the robot, if that was read."""
        viewer, self._watching = self.viewer, True
        viewer.visitor = STRANGER if self.stranger else 0
        self._leave.callback(self.hub.detach, viewer)
        self.hub.attach(viewer, cameras, self._wish())
        viewer.seat = self.seat = self._leave.enter_context(self.shared.audience.one(self.slug))
        if viewer.connection is not None:
            self._leave.callback(viewer.connection.when_free, None)
            viewer.connection.when_free(self.writer.freed.set)
        # first, or a change between snapshot and subscription would be missed
        subscribed = await self.hub.wait_until_subscribed(self.slug)
        await self.snapshots.send()
        if not subscribed:
            self.begin(self._update_when_subscribed())
        viewer.ask_count()
        self.begin(self.writer.run())
        self.begin(self.snapshots.run())

    def _wish(self) -> Wish | None:
        """Return the page's first wish, which stands in the socket's address."""
        asked = parse_qs(self.scope.get("query_string", b"").decode("latin-1")).get("watch", [""])[0]
        with contextlib.suppress(NotUnderstood):
            message = ROBOT.decode(asked)
            return Wish.of(message) if isinstance(message, Watch) else None
        return None

    async def _update_when_subscribed(self) -> None:
        await self.hub.wait_until_subscribed(self.slug, None)
        self.outdated.set()

    async def release(self) -> None:
        """Remove the viewer; the operator's turn is kept for a while."""
        self._leave.close()
        if self._watching:
            await self.controls.release()
            await self.presence.leave()

    def read(self, text: str | None, data: bytes | None) -> RobotMessage | None:
        """Return the message in a frame; None for a piece of a long one. Raises NotUnderstood.

        In bytes it may be a command for this robot, or a keep-alive or the release of one.
        """
        if data is None or not data or data[0] not in PACKED:
            whole = self.joined.take(text or "")
            return None if whole is None else ROBOT.decode(whole)
        if data[0] == PING and len(data) == PING_BYTES:
            return Ping(n=int.from_bytes(data[1:], "big"))
        if self.layout is None:
            raise NotUnderstood(SIGN_IN.text if self.stranger else UNKNOWN_COMMANDS, "command")
        try:
            return _unpacked(self.layout, data)
        except ValueError as error:
            raise NotUnderstood(f"That command was not understood: {error}; reload the page.", "command") from error

    async def take(self, message: RobotMessage) -> None:
        """Carry out urgent messages at once; queue the others. Strangers are answered without a thread."""
        sent = False
        if not self.role.person and self.stranger and not isinstance(message, Ping | Plan | Watch | Cheer):
            await self.requests.answer(message, SIGN_IN)
            return
        match message:
            case Ping():
                at_ms = int(SYSTEM.now().timestamp() * 1000)
                await self.send(json.dumps({"t": "pong", "n": message.n, "now_ms": at_ms, "link": self.hub.link}))
                if self.role.person:
                    self.presence.note()
                return
            case Plan():
                self.plans.ask(message)
                return
            case Watch():
                self.hub.choose(self.viewer, Wish.of(message))
                return
            case Cheer():
                address = str((self.scope.get("client") or ("",))[0])
                await self.requests.answer(message, self.hub.cheers(self.slug).cheer(self.role, address))
                return
            case Keep() | Released():
                await self.controls.hear(message)
                return
            case Stop() if self.role.may_stop:
                sent = await URGENT.run(bus.send_stop, self.slug, self.role.stop_grant)
        await self.requests.put(message, sent)

    async def refuse(self, error: NotUnderstood) -> None:
        """Answer a request that was not understood."""
        await self.requests.refuse(error)

    def check_in(self) -> None:
        """Note soon in the database that the person is present."""
        self.presence.note()

    def judge(self, user: Any) -> Ending | None:
        """Return why the socket ends: a clearance, a permission or the turn is gone; runs in a thread."""
        if self.viewer.trace and not user.has_perm("robots.change_robot"):
            return NOT_STAFF
        if self.role.queued and not cleared(user, Robot.objects.get(slug=self.slug)):
            return UNCLEARED
        return self.access.judge()

    async def shut(self, ending: Ending) -> None:
        """Close, and end the turn unless another session of the person continues it."""
        self.hub.detach(self.viewer)
        person = self.sign_in.user if self.sign_in else 0  # a later snapshot has no person any more
        await asyncio.gather(self.close(ending.code, ending.text), self.presence.give_up(person, ending))


def _unpacked(layout: CommandLayout, data: bytes) -> RobotMessage:
    """Return the message in a packet. Raises ValueError."""
    if data[0] == TYPE:
        found = layout.decode(data, int(SYSTEM.now().timestamp() * 1000))
        return Command(kind=found.kind, seq=found.seq, args=dict(found.args), seen=found.seen_ms)
    hold = layout.decode_hold(data)
    return Keep(seq=hold.seq, args=dict(hold.args)) if hold.held else Released(seq=hold.seq)


class Requests:
    """The requests of one page: carried out in order, in a thread, each with person, session and turn read again."""

    def __init__(self, socket: Socket, viewer: Viewer, controls: HeldControls, snapshots: SnapshotSender) -> None:
        self._socket, self._viewer, self._controls, self._snapshots = socket, viewer, controls, snapshots
        self._queue: asyncio.Queue[tuple[RobotMessage, bool]] = asyncio.Queue(WAITING)
        self._running = False

    async def put(self, message: RobotMessage, sent: bool) -> None:
        """Queue a request, or refuse it if too many wait; the first one starts the task that carries them out.

        `sent`: the stop was sent over the bus already.
        """
        try:
            self._queue.put_nowait((message, sent))
        except asyncio.QueueFull:
            await self.answer(message, Answer(False, "The database is too slow now; nothing was done.", "busy"))
            return
        if not self._running:
            self._running = True
            self._socket.begin(self.run())
        if isinstance(message, Command):
            self._controls.press(message)

    async def run(self) -> None:
        """Carry out queued requests."""
        while True:
            message, sent = await self._queue.get()
            try:
                answer = await self._socket.orm(act, self._socket.scope, self._viewer.slug, message, sent)
            except Error as error:
                answer = Answer(False, down_text(error), "store_down")
            except Exception:
                log.exception("a request failed")
                answer = Answer(False, OUR_FAULT, "error")
            if answer.trace is not None:
                await self._socket.shared.hub.trace(self._viewer, answer.trace)
            if isinstance(message, Command):
                await self._controls.assign(message, answer.new_command)
            await self.answer(message, answer)

    async def answer(self, message: RobotMessage, answer: Answer) -> None:
        """Send an answer, and a snapshot if the request changed something."""
        seq = message.seq if isinstance(message, Command) else 0
        await self._send(str(message.__struct_config__.tag), seq, answer)
        if answer.changed:
            await self._snapshots.send()

    async def refuse(self, error: NotUnderstood) -> None:
        """Answer a request that was not understood."""
        await self._send(error.to, error.seq, Answer(False, str(error), "bad_request"))

    async def _send(self, to: str, seq: int, answer: Answer) -> None:
        await self._socket.send(json.dumps({"t": "answer", "to": to, "seq": seq or None, **answer.fields()}))


class PlanSender:
    """Asks for the previews of one page, and sends the newest answer; an older one that waits is dropped."""

    def __init__(self, socket: Socket, slug: str, writer: Writer) -> None:
        self._socket, self._slug, self._writer = socket, slug, writer
        self._text = ""  # the newest answer, while it waits
        self._sending = False

    @property
    def closed(self) -> bool:
        """Return whether nobody waits for an answer any more."""
        return self._socket.closed

    def ask(self, message: Plan) -> None:
        """Ask for a preview."""
        question = Question(self, self._socket.scope, self._slug, message)
        self._socket.shared.previews.ask(self._socket.role.person, question)

    def answer(self, text: str) -> None:
        """Send an answer soon."""
        self._text = text
        if not self._sending:
            self._sending = True
            self._socket.begin(self._send())

    async def _send(self) -> None:
        while self._text:
            text, self._text = self._text, ""
            await self._writer.tell("plan", text)
        self._sending = False
