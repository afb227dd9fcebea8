"""The robot's socket: pictures, states and events out; commands, stop and presence in.

A stop and the keep-alives of a held motion do not wait for the database: they go to the bus at once, by what this
socket was told last. Everything else is carried out in order.
"""

import asyncio
import contextlib
import json
import logging
from functools import cache
from math import inf
from typing import Any
from urllib.parse import parse_qs

from django.conf import settings
from django.db import Error

from portal.edge.dropped import drop
from portal.edge.limits import AddressCount
from portal.live import codes
from portal.live.actions import SIGN_IN, Answer, act
from portal.live.hub import hub
from portal.live.messages import (
    ROBOT,
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
from portal.live.people import current_user, session_key
from portal.live.previews import Question, previewer
from portal.live.rooms import Cameras
from portal.live.threads import URGENT
from portal.live.viewing import NOT_FOUND, Viewing
from portal.stores import down_text
from queueing import services as queue
from robots import bus
from robots.kit.clock import SYSTEM
from robots.kit.description import coding, views
from robots.models import Robot

log = logging.getLogger(__name__)
WAITING = 64
HEARD_S = 0.1  # a page that holds its controls says so more often
FULL = 4503
FULL_TEXT = "As many people watch this robot as the portal can serve. This page tries again."
ENOUGH_TEXT = "You watch robots in as many pages as one account may. Close one of them."
OUR_FAULT = "The portal failed at this request. Staff can find the reason in the log."


@cache
def accounts() -> AddressCount:
    """Return this process's counter of the sockets of each account."""
    return AddressCount(settings.LIMITS["SOCKETS_OF_ACCOUNT"])


class RobotConsumer(Viewing):
    """One viewer of one robot; the holder of the grant may also command it."""

    wire = ROBOT

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self._asked: asyncio.Queue[tuple[RobotMessage, bool]] = asyncio.Queue(WAITING)
        self._serving = self._seeing = self._unseen = self._previewing = False
        self._here = SYSTEM.now()  # when the page last reported
        self._plan = ""
        self._planning = asyncio.Event()
        self._pressed = self._holding = 0  # the number of the held motion that is pressed; its command, once written
        self._pressed_at = -inf  # when the page said so last
        self._held: frozenset[str] | None = None
        self._cameras: Cameras | None = None  # that the robot has

    async def opened(self) -> None:
        """Send the snapshot, start to forward."""
        self.slug = self.scope["url_route"]["kwargs"]["slug"]
        if not (self.stranger() and hub().viewers(self.slug)):  # one more watcher needs nothing from the database
            try:
                self._held, self._cameras = await self.orm(self._look)
            except Robot.DoesNotExist:
                await self.close(NOT_FOUND)
                return
            except Error as error:
                await self.store_down(error)
        if self.stranger() and hub().strangers(self.slug) >= settings.LIMITS["VIEWERS"]:
            drop("found the robot's places taken")
            await self.close(FULL, FULL_TEXT)
            return
        if not self._enters():
            drop("of an account that has enough")
            await self.close(FULL, ENOUGH_TEXT)
            return
        await self.view(self._wish(), self._cameras)
        if self.me:
            self.check_in()

    def _enters(self) -> bool:
        """Count the socket for its account. Return False if that has too many."""
        if not self.me:
            return True
        account = str(self.me)
        entered = accounts().enter(account)
        if entered:
            self._leave.callback(accounts().leave, account)
        return entered

    async def left(self) -> None:
        """Remove the viewer; the operator's turn is kept for a while."""
        await super().left()
        if self.viewer is None:
            return
        if self._holding:
            await self._keep(self._holding, held=False)
        if self.me:
            await self.orm(self._mark_left)

    def check_in(self) -> None:
        """Note in the database that the person is present; beside requests, which must not wait for it."""
        self._unseen, self._here = True, SYSTEM.now()
        if not self._seeing:
            self._seeing = True
            self.begin(self._see())

    async def _see(self) -> None:
        try:
            while self._unseen:  # a note that has begun may be older than what asked for the next one
                self._unseen = False
                with contextlib.suppress(Exception):  # the next ping notes the presence again
                    await self.orm(self._mark_seen)
        finally:
            self._seeing = False

    def _ask(self, message: RobotMessage, sent: bool) -> None:
        """Queue a request; the first one starts the task that carries them out. Raises QueueFull."""
        self._asked.put_nowait((message, sent))
        if not self._serving:
            self._serving = True
            self.begin(self._serve())

    def _wish(self) -> Watch | None:
        """Return what the page wants from the beginning, which stands in the socket's address."""
        asked = parse_qs(self.scope.get("query_string", b"").decode("latin-1")).get("watch", [""])[0]
        with contextlib.suppress(NotUnderstood):
            wish = ROBOT.decode(asked)
            return wish if isinstance(wish, Watch) else None
        return None

    def _look(self) -> tuple[frozenset[str], Cameras]:
        """Find out whether anybody is signed in; return the kinds of held motions, and what cameras there are.

        Raises Robot.DoesNotExist.
        """
        user = current_user(self.scope)
        self.me, self.nobody = user.pk or 0, not user.is_authenticated
        robot = Robot.objects.get(slug=self.slug)
        try:
            held = frozenset(c.kind for c in robot.spec().commands if c.held)
            described = robot.description()
            return held, Cameras(len(views(described)), coding(described))
        except (LookupError, ImportError, OSError):  # its package is not installed
            return frozenset(), Cameras()

    def _mark_left(self) -> None:
        with self._noting:
            user = current_user(self.scope)
            if user.is_authenticated and not self.goes_on_elsewhere(user.pk):
                queue.note_disconnection(Robot.objects.get(slug=self.slug), user, SYSTEM.now(), session_key(self.scope))

    def goes_on_elsewhere(self, person: int) -> bool:
        """Return whether the person's page goes on over the operator's stream, which has just been opened."""
        return codes.lately_opened(self.slug, person)

    def _mark_seen(self) -> None:
        with self._noting:
            user = current_user(self.scope)
            if user.is_authenticated and not self.over:
                robot = Robot.objects.get(slug=self.slug)
                queue.note_presence(robot, user, self._here, classic=False, session=session_key(self.scope))

    async def take(self, message: RobotMessage) -> None:
        """Do urgent things at once; queue the rest. Strangers are answered without a thread, however much they send."""
        if not self.me and self.stranger() and not isinstance(message, Ping | Plan | Watch):
            await self._answer(message, SIGN_IN)
        else:
            await self._do(message)

    async def _do(self, message: RobotMessage) -> None:
        sent = False
        match message:
            case Ping():
                at_ms = int(SYSTEM.now().timestamp() * 1000)
                await self.send(json.dumps({"t": "pong", "n": message.n, "now_ms": at_ms, "link": hub().link}))
                if self.me:
                    self.check_in()
                return
            case Stop() if self.may_stop:
                sent = await URGENT.run(bus.send_stop, self.slug, self.grant)
            case Plan():
                previewer().ask(self.me, Question(self, self.scope, self.slug, message))
                return
            case Watch():
                if self.viewer is not None:
                    hub().choose(self.viewer, message)
                return
            case Keep() | Released():
                await self._hear(message)
                return
        try:
            self._ask(message, sent)
        except asyncio.QueueFull:
            await self._answer(message, Answer(False, "The database is too slow now; nothing was done.", "busy"))
            return
        # whether they drive is judged where it is written: what this socket was told last may be older than the press
        if isinstance(message, Command) and self._is_held(message):
            self._pressed, self._holding, self._pressed_at = message.seq, 0, SYSTEM.monotonic()

    def _is_held(self, command: Command) -> bool:
        return self._held is None or command.kind in self._held

    async def refuse(self, error: NotUnderstood) -> None:
        """Answer what was wrong with a request."""
        await self._tell(error.to, error.seq, Answer(False, str(error), "bad_request"))

    async def _hear(self, message: Keep | Released) -> None:
        """Pass on that this page holds its command, or has let go; before it is written, note it for `_written`."""
        if message.seq != self._pressed:
            return
        command, held = self._holding, isinstance(message, Keep)
        self._pressed_at = SYSTEM.monotonic()
        if not held:
            self._pressed = self._holding = 0
        if command:
            await self._keep(command, held, message.args if isinstance(message, Keep) else {})

    async def _written(self, message: Command, command: int) -> None:
        """Keep the held motion that this page began; its command, 0 if none was written, is known only now.

        So no page keeps a motion that another began, whatever the numbers of their commands.
        """
        pressed = message.seq == self._pressed
        if pressed:
            self._pressed, self._holding = message.seq if command else 0, command
        if command and not (pressed and SYSTEM.monotonic() - self._pressed_at > HEARD_S):
            await self._keep(command, held=pressed)

    async def _keep(self, command: int, held: bool, args: dict[str, int | float] | None = None) -> None:
        await URGENT.run(bus.send_keep_alive, self.slug, command, held, args or {})

    async def _serve(self) -> None:
        """Carry out queued requests in order."""
        while True:
            message, sent = await self._asked.get()
            try:
                answer = await self.orm(act, self.scope, self.slug, message, sent)
            except Error as error:
                answer = Answer(False, down_text(error), "store_down")
            except Exception:
                log.exception("a request failed")
                answer = Answer(False, OUR_FAULT, "error")
            if answer.trace is not None and self.viewer is not None:
                await hub().trace(self.viewer, answer.trace)
            if isinstance(message, Command) and self._is_held(message):
                await self._written(message, answer.new_command)
            await self._answer(message, answer)

    def planned(self, said: str) -> None:
        """Send the answer of a preview soon; an older one that was not sent is dropped."""
        self._plan = said
        self._planning.set()
        if not self._previewing:
            self._previewing = True
            self.begin(self._preview())

    async def _preview(self) -> None:
        while True:
            await self._planning.wait()
            self._planning.clear()
            said, self._plan = self._plan, ""
            await self.send(said)

    async def _answer(self, message: RobotMessage, answer: Answer) -> None:
        seq = message.seq if isinstance(message, Command) else 0
        await self._tell(str(message.__struct_config__.tag), seq, answer)
        if answer.changed:
            await self.send_snapshot()

    async def _tell(self, to: str, seq: int, answer: Answer) -> None:
        await self.send(json.dumps({"t": "answer", "to": to, "seq": seq or None, **answer.fields()}))
